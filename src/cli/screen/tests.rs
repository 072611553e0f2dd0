use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use super::draw::draw;
use super::glyphs::Glyphs;
use super::input::TypedLine;
use crate::instrument::Channel;
use crate::session::{
    Answer, Band, CellView, GaugeView, Message, OperatorEvent, PlanPosition, Progress, Prompt,
    PromptKind, Purpose, RepeatSpread, SessionView, SettleView, SkipScope, StiffnessSoFar, Task,
    ZeroView,
};
use crate::test_point::{Branch, Direction, PoseId};

fn gauge(channel: Channel, name: &str, value_si: f64, step: f64, raw: &str) -> GaugeView {
    GaugeView {
        channel,
        name: name.to_owned(),
        value_si: Some(value_si),
        raw: raw.to_owned(),
        unit: String::new(),
        resolution_si: Some(step),
        age_s: Some(0.02),
        stale: false,
        rate_hz: Some(50.0),
        extremes_si: None,
        link: String::new(),
        sign_known: true,
    }
}

/// Five repeats of the first loads, one of them off.
fn cell() -> CellView {
    CellView {
        spreads: (0..3)
            .map(|step| RepeatSpread {
                target_n: -10.0 * f64::from(step),
                branch: Branch::Loading,
                n: 5,
                mean_m: -47.3e-6 * f64::from(step),
                range_m: 2.1e-6,
            })
            .collect(),
        stiffness: Some(StiffnessSoFar {
            stiffness_n_per_m: 0.2114e6,
            expanded_n_per_m: Some(0.0031e6),
            k: Some(2.31),
            dof: 8.0,
            runs: 5,
            with_one_more_n_per_m: Some(0.0027e6),
        }),
        no_stiffness: None,
        flags: vec!["repeat 4 at -20 N is 6 um off the others".to_owned()],
    }
}

/// A load being brought on in the middle of a session.
fn view() -> SessionView {
    SessionView {
        session: "bench-7".to_owned(),
        procedure: "paper".to_owned(),
        now_s: 812.0,
        task: Task::Load {
            target_n: -30.0,
            purpose: Purpose::Reading,
        },
        place: Some(PlanPosition {
            pose: PoseId::new("P2"),
            direction: Direction::Y.into(),
            branch: Branch::Loading,
            step: 3,
            steps: 8,
            target_n: -30.0,
            repeat: 2,
            repeats: 5,
            attempt: 1,
            extra_hold_s: None,
            cell: 4,
            cells: 12,
        }),
        force: gauge(
            Channel::Force,
            "mark10-series5 3791204",
            -28.4,
            0.1,
            "28.4 N",
        ),
        displacements: vec![gauge(
            Channel::Displacement,
            "mitutoyo-01a",
            -134.0e-6,
            1e-6,
            "01A-0000.134",
        )],
        band: Some(Band {
            target_n: -30.0,
            tolerance_n: 0.5,
            from_n: -20.0,
            largest_n: 70.0,
            inside: false,
            overshoot_n: 0.0,
        }),
        settle: Some(SettleView {
            dwell_s: 0.0,
            dwell_needed_s: 2.0,
            force_spread_n: Some(1.2),
            force_spread_limit_n: 1.0,
            force_slope_n_per_s: Some(-0.8),
            force_slope_limit_n_per_s: 0.25,
            spread_m: Some(4.2e-6),
            spread_limit_m: 2e-6,
            slope_m_per_s: Some(-3.1e-6),
            slope_limit_m_per_s: 0.5e-6,
            settled: false,
        }),
        cell: cell(),
        zero: Some(ZeroView {
            label: "P2-y".to_owned(),
            at_s: 700.0,
            drift_m: Some(1.2e-6),
            drift_limit_m: 5e-6,
        }),
        progress: Progress {
            accepted: 177,
            skipped: 1,
            planned: 480,
            left_s: 5400.0,
        },
        prompt: None,
        held_up: Vec::new(),
        messages: vec![
            Message {
                text: "stored: -20.1 N, -95 um".to_owned(),
                urgent: false,
            },
            Message {
                text: "released to -1.0 N".to_owned(),
                urgent: false,
            },
        ],
        warnings: vec!["force gauge 3791204: calibration was due on 2026-09-01".to_owned()],
    }
}

fn drawn(view: &SessionView, input: &TypedLine, size: (u16, u16), unicode: bool) -> String {
    let glyphs = Glyphs::of_locale(|_| Some(if unicode { "C.UTF-8" } else { "C" }.to_owned()));
    let mut terminal = Terminal::new(TestBackend::new(size.0, size.1)).unwrap();
    terminal
        .draw(|area| draw(area, view, input, glyphs))
        .unwrap();
    let buffer = terminal.backend().buffer();
    let rows = (0..size.1).map(|y| {
        let row: String = (0..size.0).map(|x| buffer[(x, y)].symbol()).collect();
        row.trim_end().to_owned() + "\n"
    });
    rows.collect()
}

fn press(input: &mut TypedLine, code: KeyCode) -> Option<OperatorEvent> {
    input.key(KeyEvent::new(code, KeyModifiers::NONE))
}

#[test]
fn the_screen_of_a_load_shows_the_task_and_the_values() {
    for size in [(80, 24), (100, 34), (140, 45)] {
        let text = drawn(&view(), &TypedLine::default(), size, false);
        for wanted in [
            "bench-7 | procedure paper | 177 of 480 readings, 1 skipped | 1 h 30 min left",
            "calibration was due on 2026-09-01",
            "P2 y | loading | load 4 of 8 | repeat 2 of 5 | cell 5 of 12",
            "Turn the jack to -30.0 N   1.6 N more",
            "settling [",
            "spread 4.2/2.0 um",
            "K = 0.2114 N/um, U = 0.0031 N/um",
            "k = 2.31",
            "zero P2-y, drift 1.2 um (limit 5.0)",
            "stored: -20.1 N, -95 um",
            "any key: take  r redo",
        ] {
            assert!(
                text.contains(wanted),
                "{wanted:?} is missing at {size:?}:\n{text}"
            );
        }
    }
    let small = drawn(&view(), &TypedLine::default(), (80, 24), false);
    assert!(
        small.contains(" -28.4 N") && small.contains(" -134 um"),
        "{small}"
    );
}

#[test]
fn the_displacement_shows_micrometres_though_the_gauge_steps_in_a_thousandth_of_a_millimetre() {
    let big = drawn(&view(), &TypedLine::default(), (100, 34), false);
    // The top row of -134 in glyphs.
    assert!(big.contains("|      #  ### # # "), "{big}");
}

#[test]
fn a_stale_gauge_is_never_shown_as_a_number_without_the_word() {
    let mut stale = view();
    stale.displacements[0].stale = true;
    stale.displacements[0].value_si = None;
    stale.displacements[0].age_s = Some(4.0);
    let text = drawn(&stale, &TypedLine::default(), (100, 34), false);
    assert!(text.contains("STALE, 4 s ago"), "{text}");
    let mut lost = view();
    lost.force.link = "the port is gone; looking for the gauge, try 3".to_owned();
    let text = drawn(&lost, &TypedLine::default(), (100, 34), false);
    assert!(text.contains("looking for the gauge, try 3"), "{text}");
}

#[test]
fn no_size_of_terminal_breaks_the_picture() {
    for width in [1, 2, 5, 17, 40, 79, 300] {
        for height in [1, 2, 3, 7, 15, 29, 30, 90] {
            let mut asked = view();
            asked.prompt = Some(Prompt::confirm("ready", "Ready?"));
            let mut input = TypedLine::default();
            input.follow(asked.prompt.as_ref());
            drawn(&asked, &input, (width, height), true);
        }
    }
}

#[test]
fn keys_are_orders_and_every_other_key_is_the_pedal() {
    let mut input = TypedLine::default();
    assert_eq!(
        press(&mut input, KeyCode::Char('r')),
        Some(OperatorEvent::Redo)
    );
    assert_eq!(
        press(&mut input, KeyCode::Char('p')),
        Some(OperatorEvent::Pause)
    );
    assert_eq!(
        press(&mut input, KeyCode::Char('n')),
        Some(OperatorEvent::Note { text: None })
    );
    for code in [
        KeyCode::Char(' '),
        KeyCode::Enter,
        KeyCode::PageDown,
        KeyCode::F(5),
        KeyCode::Char('b'),
    ] {
        assert_eq!(
            press(&mut input, code),
            Some(OperatorEvent::Capture),
            "{code:?}"
        );
    }
    assert_eq!(press(&mut input, KeyCode::Esc), None);
    for (key, what) in [('s', SkipScope::Reading), ('S', SkipScope::Cell)] {
        assert_eq!(
            press(&mut input, KeyCode::Char(key)),
            Some(OperatorEvent::Skip { what, reason: None })
        );
    }
    press(&mut input, KeyCode::Char('g'));
    for digit in ['1', '1'] {
        press(&mut input, KeyCode::Char(digit));
    }
    assert_eq!(
        press(&mut input, KeyCode::Enter),
        Some(OperatorEvent::Goto { cell: 10 })
    );
}

#[test]
fn control_c_comes_in_two_stages_whatever_is_asked() {
    let mut input = TypedLine::default();
    input.follow(Some(&Prompt::confirm("ready", "Ready?")));
    let c = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
    assert_eq!(input.key(c), Some(OperatorEvent::Interrupt));
    input.follow(None);
    assert_eq!(input.key(c), Some(OperatorEvent::Abort));
}

#[test]
fn a_question_takes_only_an_answer_that_is_one() {
    let unit = "degC";
    let range = [-20.0, 60.0];
    let warm = Prompt::new(
        "temperature",
        "How warm is it?",
        PromptKind::Number { unit, range },
    );
    let mut asked = view();
    asked.prompt = Some(warm.clone());
    let mut input = TypedLine::default();
    input.follow(asked.prompt.as_ref());
    for digit in "215".chars() {
        press(&mut input, KeyCode::Char(digit));
    }
    assert_eq!(press(&mut input, KeyCode::Enter), None);
    let text = drawn(&asked, &input, (100, 34), false);
    assert!(
        text.contains("How warm is it?") && text.contains("-20 to 60 degC is expected"),
        "{text}"
    );
    press(&mut input, KeyCode::Backspace);
    let answer = Answer::Number(21.0);
    let id = warm.id.clone();
    assert_eq!(
        press(&mut input, KeyCode::Enter),
        Some(OperatorEvent::Answer { id, answer })
    );
    // The session shows the question until it has taken the answer: it is not asked twice.
    input.follow(Some(&warm));
    assert_eq!(
        press(&mut input, KeyCode::Char('p')),
        Some(OperatorEvent::Pause)
    );
}

#[test]
fn a_checklist_is_ticked_item_by_item() {
    let items = ["brakes on", "gauge square to the surface"]
        .map(str::to_owned)
        .to_vec();
    let list = Prompt::new("setup", "Ready?", PromptKind::Checklist(items));
    let mut asked = view();
    asked.prompt = Some(list.clone());
    let mut input = TypedLine::default();
    input.follow(Some(&list));
    assert_eq!(press(&mut input, KeyCode::Char(' ')), None);
    let text = drawn(&asked, &input, (100, 34), false);
    assert!(
        text.contains("[x] brakes on") && text.contains("[ ] <- gauge square"),
        "{text}"
    );
    let answered = press(&mut input, KeyCode::Char(' '));
    assert!(matches!(
        answered,
        Some(OperatorEvent::Answer {
            answer: Answer::Yes(true),
            ..
        })
    ));
}

#[test]
fn the_range_of_each_gauge_since_the_task_began_is_shown() {
    let mut view = view();
    view.force.extremes_si = Some([-30.5, 0.2]);
    view.displacements[0].extremes_si = Some([-140e-6, -1e-6]);
    for size in [(80, 24), (100, 34)] {
        let text = drawn(&view, &TypedLine::default(), size, false);
        assert!(text.contains("min -30.5 max 0.2"), "{text}");
        assert!(text.contains("min -140 max -1"), "{text}");
    }
}

#[test]
fn a_note_is_written_while_a_question_waits() {
    let mut input = TypedLine::default();
    let prompts = [
        (Prompt::confirm("setup", "Done?"), true),
        (
            Prompt::choice("drift", "?", &[("redo", ""), ("keep", "")]),
            false,
        ),
    ];
    for (prompt, with_control) in prompts {
        input.follow(Some(&prompt));
        let begun = if with_control {
            input.key(KeyEvent::new(KeyCode::Char('n'), KeyModifiers::CONTROL))
        } else {
            press(&mut input, KeyCode::Char('n'))
        };
        assert_eq!(begun, None);
        let mut asked = view();
        asked.prompt = Some(prompt.clone());
        assert!(drawn(&asked, &input, (80, 24), false).contains("A note on this cell"));
        for letter in "bolt".chars() {
            assert_eq!(press(&mut input, KeyCode::Char(letter)), None);
        }
        // The session goes on showing the question.
        input.follow(Some(&prompt));
        let text = Some("bolt".to_owned());
        assert_eq!(
            press(&mut input, KeyCode::Enter),
            Some(OperatorEvent::Note { text })
        );
        let asked = drawn(&asked, &input, (80, 24), false);
        assert!(asked.contains(&prompt.text), "{asked}");
        input.follow(None);
    }
}
