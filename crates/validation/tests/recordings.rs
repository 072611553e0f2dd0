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
    const PHYSICS: [&str; 14] = [
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
    ];
    let list = stiffbench_test_files::text("data/recordings/recordings.toml");
    let list = Recordings::parse("recordings.toml", list).unwrap();
    for recording in list.recording {
        let name = &recording.name;
        let mut verdicts = std::iter::once(&recording.verdict).chain(&recording.also_right);
        assert!(verdicts.all(|v| VERDICTS.contains(&v.as_str())), "{name}");
        let mut physics = recording.physics.iter().chain(&recording.not);
        assert!(physics.all(|p| PHYSICS.contains(&p.as_str())), "{name}");
        let both = recording.physics.iter().find(|p| recording.not.contains(p));
        assert_eq!(both, None, "{name}");
        assert!(
            !recording.why.is_empty() && !recording.figures.is_empty(),
            "{name}"
        );
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
