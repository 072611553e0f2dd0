//! What is known of recordings by others: `data/recordings/recordings.toml`.

use stiffbench_validation::prove::Recordings;

#[test]
fn descriptions_of_recordings_use_the_known_terms() {
    const VERDICTS: [&str; 5] = [
        "explained",
        "ambiguous",
        "unknown",
        "nothing-missing",
        "insufficient-data",
    ];
    const PHYSICS: [&str; 24] = [
        "joint-compliance",
        "joint-backlash",
        "joint-friction",
        "joint-nonlinearity",
        "base-compliance",
        "gauge-stand-compliance",
        "load-misalignment",
        "loose-member",
        "force-gauge-nonlinearity",
        "creep",
        "thermal-drift",
        "setting-in",
        "slip",
        "gauge-periodic",
        "constant-force",
        "load-dependent-friction",
        "maxwell-slip",
        "preloaded-backlash",
        "odd-polynomial",
        "end-stop",
        "joint-separation",
        "contact",
        "relaxation",
        "softening",
    ];
    let list = stiffbench_test_files::text("data/recordings/recordings.toml");
    let list = Recordings::parse("recordings.toml", list).unwrap();
    for recording in list.recording {
        let name = &recording.name;
        assert!(VERDICTS.contains(&recording.verdict.as_str()), "{name}");
        let is_known =
            |text: &String| VERDICTS.contains(&text.as_str()) || PHYSICS.contains(&text.as_str());
        assert!(recording.also_right.iter().all(is_known), "{name}");
        let right = recording.physics.iter().chain(&recording.only_in_sets);
        let mut physics = right.clone().chain(&recording.not);
        assert!(physics.all(|p| PHYSICS.contains(&p.as_str())), "{name}");
        let right = right.chain(&recording.also_right);
        let both = right.clone().find(|p| recording.not.contains(p));
        assert_eq!(both, None, "{name}");
        let twice = right
            .clone()
            .find(|p| right.clone().filter(|q| q == p).count() > 1);
        assert_eq!(twice, None, "{name}");
        // What derives from a recording may not be published under every licence.
        let may_derive = !recording.licence.contains("nothing derived");
        let has_figures = recording.line_residual_sd.is_some() || !recording.figures.is_empty();
        assert_eq!(has_figures, may_derive, "{name}");
        assert!(!recording.why.is_empty(), "{name}");
        assert!(!recording.source.is_empty(), "{name}");
        for file in &recording.files {
            let digits = file.sha256.bytes();
            assert!(file.sha256.len() == 64 && digits.clone().all(|byte| byte.is_ascii_hexdigit()));
            assert!(file.path.contains('/'), "{name}");
        }
        assert!(
            recording.figures.values().all(|figure| figure.is_finite()),
            "{name}"
        );
    }
}
