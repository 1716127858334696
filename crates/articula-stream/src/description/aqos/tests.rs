//! Decisions computed by hand, and descriptions that come back.

use super::*;
use crate::limits::DescriptionLimits;
use proptest::prelude::*;

const LIMITS: DescriptionLimits = DescriptionLimits {
    bytes: 1 << 20,
    nodes: 1 << 12,
};

fn pins(values: &[(&str, f64)]) -> Pins {
    values
        .iter()
        .map(|(name, value)| ((*name).to_owned(), *value))
        .collect()
}

fn pin(id: &str, choices: &[f64]) -> IoPin {
    IoPin {
        id: id.into(),
        semantics: None,
        choices: choices.to_vec(),
    }
}

fn column(pin: &str, values: &[f64]) -> Column {
    Column {
        pin: pin.into(),
        values: values.to_vec(),
    }
}

fn expression(text: &str) -> Expression {
    text.parse().unwrap()
}

fn again(aqos: &Aqos) -> Aqos {
    Aqos::read(aqos.write().as_bytes(), &LIMITS).unwrap()
}

#[test]
fn the_table_of_annex_b_gives_a_level_for_each_bandwidth() {
    let aqos = Aqos::one_to_one(&[8e3, 16e3, 32e3, 64e3]);
    assert_eq!(again(&aqos), aqos);
    for (rate, level) in [
        (1e3, 0.0),
        (8e3, 0.0),
        (15.9e3, 0.0),
        (16e3, 1.0),
        (63e3, 2.0),
        (1e6, 3.0),
    ] {
        let mut context = Context::default();
        context.network.available_bps = Some(rate);
        let given = aqos.bind(&context);
        assert_eq!(given, pins(&[(BANDWIDTH, rate)]));
        let decided = aqos.decide(&given).unwrap();
        assert_eq!(decided.values[LAYERS], level, "{rate} bits per second");
        assert_eq!(
            decided.reasons,
            [format!(
                "{LAYERS} = {level}: looked up at {BANDWIDTH} = {rate}"
            )]
        );
    }
    let missing = aqos.decide(&aqos.bind(&Context::default())).unwrap_err();
    assert_eq!(missing.at, BANDWIDTH);
}

#[test]
fn the_document_of_annex_b_is_read() {
    let text = "<DIA xmlns=\"urn:mpeg:mpeg21:2003:01-DIA-NS\" xmlns:mpeg7=\"urn:mpeg:mpeg7:schema:2001\" \
        xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\"><DescriptionMetadata><ClassificationSchemeAlias \
        alias=\"AQoS\" href=\"urn:mpeg:mpeg21:2003:01-DIA-AdaptationQoSCS-NS\"/></DescriptionMetadata>\
        <Description xsi:type=\"AdaptationQoSType\"><Module xsi:type=\"LookUpTableType\"><Axis iOPinRef=\"BANDWIDTH\">\
        <AxisValues xsi:type=\"IntegerVectorType\"><Vector>8 16 32 64</Vector></AxisValues></Axis>\
        <Content iOPinRef=\"LAYERS_OF_SCALABLE_BBA\"><ContentValues xsi:type=\"IntegerMatrixType\" mpeg7:dim=\"4\">\
        <Matrix>0 1 2 3</Matrix></ContentValues></Content></Module><IOPin id=\"BANDWIDTH\"><GetValue \
        xsi:type=\"SemanticalDataRefType\" semantics=\":AQoS:6.6.5.3\"/></IOPin><IOPin id=\"LAYERS_OF_SCALABLE_BBA\"/>\
        </Description></DIA>";
    let aqos = Aqos::read(text.as_bytes(), &LIMITS).unwrap();
    let mut context = Context::default();
    context.network.max_capacity_bps = Some(40.0);
    // The code is not in our list, but the name of the pin is.
    let decided = aqos.decide(&aqos.bind(&context)).unwrap();
    assert_eq!(decided.values[LAYERS], 2.0);
    let wrong = text.replace("dim=\"4\"", "dim=\"5\"");
    assert!(
        Aqos::read(wrong.as_bytes(), &LIMITS)
            .unwrap_err()
            .to_string()
            .contains("dim")
    );
    let wrong = text.replace("8 16 32 64", "8 16 16 64");
    assert!(
        Aqos::read(wrong.as_bytes(), &LIMITS)
            .unwrap_err()
            .to_string()
            .contains("rising")
    );
    let wrong = text.replace("<IOPin id=\"LAYERS_OF_SCALABLE_BBA\"/>", "");
    assert!(
        Aqos::read(wrong.as_bytes(), &LIMITS)
            .unwrap_err()
            .to_string()
            .contains("no pin of this name")
    );
}

#[test]
fn two_axes_are_floored_or_interpolated() {
    let axis = |pin: &str, values: &[f64]| Axis {
        pin: pin.into(),
        values: values.to_vec(),
    };
    let content = |pin: &str, is_linear| Content {
        pin: pin.into(),
        values: vec![0.0, 10.0, 20.0, 100.0, 110.0, 120.0],
        is_linear,
    };
    let aqos = Aqos {
        modules: vec![Module::LookUpTable(LookUpTable {
            axes: vec![axis("a", &[0.0, 1.0]), axis("b", &[0.0, 2.0, 4.0])],
            contents: vec![content("floor", false), content("line", true)],
        })],
        pins: ["a", "b", "floor", "line"].map(|id| pin(id, &[])).into(),
        constraints: Constraints::default(),
    };
    assert_eq!(again(&aqos), aqos);
    for (a, b, floor, line) in [
        (0.0, 0.0, 0.0, 0.0),
        (0.5, 3.0, 10.0, 65.0),
        (1.0, 4.0, 120.0, 120.0),
        (9.0, 9.0, 120.0, 120.0),
        (-9.0, 1.0, 0.0, 5.0),
    ] {
        let values = aqos.decide(&pins(&[("a", a), ("b", b)])).unwrap().values;
        assert_eq!(
            (values["floor"], values["line"]),
            (floor, line),
            "at {a}, {b}"
        );
    }
}

fn utility() -> Aqos {
    Aqos {
        modules: vec![
            Module::StackFunction(StackFunction {
                pin: "joints".into(),
                expression: expression("joints_per_ms frame_budget_ms * floor"),
            }),
            Module::UtilityFunction(UtilityFunction {
                constraints: vec![
                    column("rate", &[10.0, 20.0, 40.0, 30.0]),
                    column("joints", &[5.0, 24.0, 35.0, 24.0]),
                ],
                operators: vec![column("level", &[0.0, 2.0, 3.0, 9.0])],
                utility: column("worth", &[1.0, 5.0, 7.0, 5.0]),
            }),
        ],
        pins: [
            "rate",
            "joints",
            "joints_per_ms",
            "frame_budget_ms",
            "level",
            "worth",
        ]
        .map(|id| pin(id, &[]))
        .into(),
        constraints: Constraints::default(),
    }
}

#[test]
fn the_point_of_most_worth_that_fits_is_taken() {
    let aqos = utility();
    assert_eq!(again(&aqos), aqos);
    let decide = |rate: f64, budget: f64| {
        aqos.decide(&pins(&[
            ("rate", rate),
            ("joints_per_ms", 10.0),
            ("frame_budget_ms", budget),
        ]))
    };
    assert_eq!(decide(100.0, 9.0).unwrap().values["level"], 3.0);
    assert_eq!(
        decide(100.0, 3.0).unwrap().values["level"],
        2.0,
        "the cheaper of two equal ones"
    );
    assert_eq!(decide(15.0, 3.0).unwrap().values["level"], 0.0);
    assert!(decide(5.0, 3.0).unwrap_err().what.contains("no point"));
    let reasons = decide(15.0, 3.0).unwrap().reasons;
    assert_eq!(
        reasons[0],
        "joints = 30: \"joints_per_ms frame_budget_ms * floor\""
    );
}

#[test]
fn choices_keep_limits_and_reach_the_best_objective() {
    let aqos = Aqos {
        modules: vec![Module::StackFunction(StackFunction {
            pin: "rate".into(),
            expression: expression("level 8 * tier 1 + /"),
        })],
        pins: vec![
            pin("level", &[0.0, 1.0, 2.0, 3.0]),
            pin("tier", &[0.0, 1.0]),
            pin("rate", &[]),
            pin("bandwidth", &[]),
        ],
        constraints: Constraints {
            limits: vec![expression("rate bandwidth le"), expression("level 3 lt")],
            objective: Some(Objective::Maximise(expression("level 10 * tier -"))),
        },
    };
    assert_eq!(again(&aqos), aqos);
    let decide = |bandwidth: f64| aqos.decide(&pins(&[("bandwidth", bandwidth)]));
    let chosen = |bandwidth: f64| {
        let values = decide(bandwidth).unwrap().values;
        (values["level"], values["tier"])
    };
    assert_eq!(chosen(100.0), (2.0, 0.0));
    assert_eq!(chosen(8.0), (2.0, 1.0));
    assert_eq!(chosen(7.0), (1.0, 1.0));
    assert_eq!(chosen(0.0), (0.0, 0.0));
    assert!(decide(-1.0).unwrap_err().what.contains("does not hold"));
    let told = aqos
        .decide(&pins(&[("bandwidth", 100.0), ("level", 1.0)]))
        .unwrap();
    assert_eq!(told.values["level"], 1.0, "a choice that is given is none");
    let constraints = Constraints::read(aqos.constraints.write().as_bytes(), &LIMITS).unwrap();
    assert_eq!(constraints, aqos.constraints);
}

#[test]
fn what_cannot_be_decided_says_why() {
    let mut circle = utility();
    circle.modules = vec![
        Module::StackFunction(StackFunction {
            pin: "rate".into(),
            expression: expression("level"),
        }),
        Module::StackFunction(StackFunction {
            pin: "level".into(),
            expression: expression("rate"),
        }),
    ];
    assert!(
        circle
            .decide(&Pins::new())
            .unwrap_err()
            .what
            .contains("no module can set it")
    );
    let mut many = utility();
    many.pins
        .extend((0..9).map(|i| pin(&format!("c{i}"), &[0.0, 1.0, 2.0, 3.0])));
    assert!(
        many.decide(&Pins::new())
            .unwrap_err()
            .what
            .contains("combinations")
    );
    assert!(
        utility()
            .decide(&pins(&[("level", 1.0)]))
            .unwrap_err()
            .what
            .contains("result")
    );
    assert!(
        utility()
            .decide(&pins(&[("rate", f64::NAN)]))
            .unwrap_err()
            .what
            .contains("finite")
    );
    for text in ["", "1 2", "+", "1 +", "1 2 + +", "neg"] {
        assert!(text.parse::<Expression>().is_err(), "{text}");
    }
    assert!(expression("1 0 /").value(&Pins::new()).is_err());
    assert_eq!(expression("a").value(&Pins::new()), Ok(None));
}

proptest! {
    #[test]
    fn a_table_stays_within_its_values(
        rises in prop::collection::vec(0.1f64..10.0, 1..6),
        values in prop::collection::vec(-5.0f64..5.0, 6),
        at in -20.0f64..80.0,
        is_linear: bool,
    ) {
        let axis: Vec<f64> = rises.iter().scan(0.0, |sum, rise| { *sum += rise; Some(*sum) }).collect();
        let values = values[..axis.len()].to_vec();
        let table = LookUpTable {
            axes: vec![Axis { pin: "a".into(), values: axis.clone() }],
            contents: vec![Content { pin: "c".into(), values: values.clone(), is_linear }],
        };
        table.check().unwrap();
        let found = table.value(&table.contents[0], &[at]);
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        prop_assert!(found >= least - 1e-9 && found <= most + 1e-9);
        for (place, value) in axis.iter().zip(&values) {
            prop_assert_eq!(table.value(&table.contents[0], &[*place]), *value);
        }
    }
}
