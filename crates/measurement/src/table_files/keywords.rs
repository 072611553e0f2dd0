//! Words in names of columns, in the languages of machines and their operators.

/// Force: English, German, French, Italian, Spanish, Portuguese, Polish, Czech, Hungarian, Turkish, Russian, Chinese, Japanese; as are the others.
pub(crate) const FORCE: &str = "force kraft fuerza forza load last charge carico carga effort prufkraft standardkraft normalkraft f forca \
     sila obciazenie zatizeni ero kuvvet yuk сила нагрузка усилие 力 载荷 负荷 荷重 試験力";

/// Displacement.
pub(crate) const DISPLACEMENT: &str = "displacement disp weg verschiebung deplacement spostamento desplazamiento deflection travel extension extensometer \
     allungamento elongation allongement alargamiento auslenkung durchbiegung traversenweg standardweg stroke crosshead deformation verformung fleche course corsa freccia flecha \
     recorrido carrera messuhr dial comparateur comparatore comparador position posicion posizione distance deslocamento \
     przemieszczenie wydluzenie ugiecie posuv draha elmozdulas deplasman uzama перемещение ход деформация прогиб \
     位移 行程 变形 変位 伸び ストローク";

/// Moment.
pub(crate) const MOMENT: &str =
    "moment torque drehmoment couple momento coppia tork момент 力矩 扭矩 モーメント";

/// Rotation of the end.
pub(crate) const ROTATION: &str =
    "rotation rot verdrehung drehung kippung rotazione rotacion obrot donme поворот 转角 回転";

/// Stress.
pub(crate) const STRESS: &str = "stress spannung contrainte tensione esfuerzo tensao naprezenie napeti gerilme напряжение 应力 応力";

/// Strain, or an angle.
pub(crate) const STRAIN: &str = "strain dehnung deformazione odksztalcenie angle winkel angolo angulo kat uhel szog aci угол 应变 ひずみ 角度";

/// A specimen of several.
pub(crate) const SPECIMEN: &str = "specimen probe prufling prufkorper eprouvette echantillon campione provino muestra probeta probka vzorek \
     numune образец 试样 試験片";

/// Position of a point in the axes of a tracker.
pub(crate) const POSITION: &str = "position pos posicion posizione lage koordinate coordinate coord tracker smr tcp pozycja положение 坐标 座標 位置";

/// Letters that are displacements where they stand alone.
pub(crate) const DISPLACEMENT_LETTERS: &str = "x d s u w delta";

/// Pose.
pub(crate) const POSE: &str = "pose pos stellung haltung posture posa postura position posicion posizione configuration konfiguration punkt messpunkt point \
     punto lage poza поза позиция 位姿 姿勢";

/// Direction of the load.
pub(crate) const DIRECTION: &str = "direction richtung direzione direccion dir axis achse axe asse eje sens verso direcao kierunek smer irany yon \
     направление 方向";

/// Run.
pub(crate) const REPEAT: &str = "repeat rep repetition wiederholung wdh ripetizione repeticion repetibilite run lauf trial series essai serie prova ensayo versuch durchgang durchlauf messreihe \
     cycle zyklus ciclo messung mesure misura medida segment proba cykl mereni opakovani tekrar cevrim цикл испытание 循环 次数 サイクル";

/// Loading or unloading.
pub(crate) const BRANCH: &str = "branch ast branche ramo rama";

/// Time.
pub(crate) const TIME: &str = "time zeit temps tempo tiempo timestamp zeitstempel uhrzeit heure ora hora date datum x_value laufzeit prufzeit \
     testzeit messzeit elapsed czas cas ido zaman sure время 时间 時間";

/// Temperature.
pub(crate) const TEMPERATURE: &str =
    "temperature temp temperatur temperatura teplota homerseklet sicaklik температура 温度";

/// What columns have that hold a plan, a limit or a rate rather than what was read.
pub(crate) const NOT_READ: &str = "soll sollwert target setpoint nominal consigne objetivo max min maximum minimum peak sd std stdev error fehler rate speed \
     geschwindigkeit vitesse velocita velocidad command";

/// Whether a word is one of these; in a script without blanks it may have others around it.
pub(crate) fn has(words: &str, word: &str) -> bool {
    const FIRST_IDEOGRAPH: char = '\u{2e80}';
    words.split_whitespace().any(|known| {
        known == word || known.starts_with(|c| c >= FIRST_IDEOGRAPH) && word.contains(known)
    })
}

/// Whether a word stands in names of columns.
pub(super) fn is_known(word: &str) -> bool {
    const ALL: [&str; 11] = [
        FORCE,
        DISPLACEMENT,
        MOMENT,
        ROTATION,
        POSITION,
        POSE,
        DIRECTION,
        REPEAT,
        BRANCH,
        TIME,
        TEMPERATURE,
    ];
    ALL.iter().any(|words| has(words, word))
}

/// Letters and digits between everything else.
pub(crate) fn words_of(text: &str) -> impl Iterator<Item = &str> {
    let words = text.split(|c: char| !c.is_alphanumeric());
    words.filter(|word| !word.is_empty())
}

/// Small letters without accents.
pub(crate) fn plain(text: &str) -> String {
    const ACCENTED: [(&str, char); 15] = [
        ("äáàâãąă", 'a'),
        ("çćč", 'c'),
        ("ďđ", 'd'),
        ("éèêëęě", 'e'),
        ("ğ", 'g'),
        ("íìîïı", 'i'),
        ("ł", 'l'),
        ("ñńň", 'n'),
        ("öóòôõő", 'o'),
        ("ř", 'r'),
        ("śšş", 's'),
        ("ť", 't'),
        ("üúùûůű", 'u'),
        ("ý", 'y'),
        ("źżž", 'z'),
    ];
    let letters = text.trim().chars().flat_map(char::to_lowercase);
    letters
        // The dot that the small letter of a Turkish capital keeps.
        .filter(|c| *c != '\u{307}')
        .map(|c| {
            let mut known = ACCENTED.into_iter();
            let base = known.find(|(accented, _)| !c.is_ascii() && accented.contains(c));
            base.map_or(c, |(_, base)| base)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accents_and_capitals_do_not_matter() {
        for (name, expected) in [
            ("Déplacement", "deplacement"),
            ("Obciążenie", "obciazenie"),
            ("SIŁA", "sila"),
            ("Yük", "yuk"),
            ("DİREÇÃO", "direcao"),
            ("Нагрузка", "нагрузка"),
        ] {
            assert_eq!(plain(name), expected);
        }
    }

    #[test]
    fn a_script_without_blanks_has_words_in_words() {
        assert!(has(DISPLACEMENT, "横梁位移") && has(FORCE, "最大试验力"));
        assert!(!has(FORCE, "forces") && !has(TIME, "位移"));
    }
}
