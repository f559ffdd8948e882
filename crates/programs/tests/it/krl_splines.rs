//! Spline motions of KRL: where SLIN, SCIRC, SPTP and blocks of SPLINE lead, how they are written back, and what is refused.

use kinetostat_programs::{
    NumberFormat, Orientation, Sampling, Toolpath, WriteOptions,
    gcode::Calls,
    robot::{Language, RobotOptions, RobotProgram},
};
use nalgebra::{UnitQuaternion, Vector3};

use crate::robot_expanded::moved;

fn parse(source: &str) -> Result<RobotProgram, String> {
    RobotProgram::parse(source, "p.src", Language::Krl, None, &RobotOptions::default())
        .map_err(|refused| refused.to_string())
}

fn expanded(source: &str) -> Result<RobotProgram, String> {
    RobotProgram::parse_expanded(source, "p.src", Language::Krl, [], &RobotOptions::default(), true)
        .map_err(|refused| refused.to_string())
}

fn coarse(program: &RobotProgram) -> Toolpath {
    program.toolpath(Sampling::new(1e3, 1e3).unwrap().with_max_turn(9.0).unwrap()).unwrap()
}

/// A start at (0, 0, 0).
const GO: &str = "PTP {X 0,Y 0,Z 0,A 0,B 0,C 180}\n";

/// Tangents by hand: along a line to its end, along the first motion behind the point, or halfway between two chords.
#[test]
fn splines_lead_through_their_points() {
    let source = format!(
        "$VEL.CP=0.05\n{GO}SPLINE WITH $VEL.CP=0.02\nSLIN {{X 10}} WITH $ACC.CP=1\nSPL {{X 20}} WITH $VEL.CP=0.01\nSPL {{Y 10}}\nSCIRC \
         {{X 30,Y 20}},{{X 20,Y 30}}\nSPL {{X 0,Y 30}}\nENDSPLINE C_SPL\nSLIN {{X 0,Y 0}} WITH $VEL={{CP 0.03,ORI1 200}}\nSPTP {{Z 5}}\n"
    );
    let program = parse(&source).unwrap();
    let path = program.toolpath(Sampling::new(0.01, 1e3).unwrap()).unwrap();
    let end = |motion: usize| path.points().iter().rfind(|point| point.source.segment == motion).unwrap();
    let half = 0.5f64.sqrt();
    for (motion, position, tangent, feed) in [
        (1, [10.0, 0.0, 0.0], [1.0, 0.0, 0.0], Some(1200.0)),
        (2, [20.0, 0.0, 0.0], [half, half, 0.0], Some(600.0)),
        // The circle about (20, 20) begins along +x.
        (3, [20.0, 10.0, 0.0], [1.0, 0.0, 0.0], Some(1200.0)),
        (4, [20.0, 30.0, 0.0], [-1.0, 0.0, 0.0], Some(1200.0)),
        (5, [0.0, 30.0, 0.0], [-1.0, 0.0, 0.0], Some(1200.0)),
        (6, [0.0, 0.0, 0.0], [0.0, -1.0, 0.0], Some(1800.0)),
    ] {
        let point = end(motion);
        assert!((point.position_mm - Vector3::from(position)).norm() < 1e-9, "{motion}: {}", point.position_mm);
        assert!((point.tangent - Vector3::from(tangent)).norm() < 1e-9, "{motion}: {}", point.tangent);
        assert!(
            point.cutting && point.feed_mm_per_min.map(f64::round) == feed,
            "{motion}: {:?}",
            point.feed_mm_per_min
        );
    }
    assert!(!end(7).cutting && end(7).feed_mm_per_min.is_none());
    // A spline has one point for each of its motions; those of the circle are on it.
    let count = |motion: usize| path.points().iter().filter(|point| point.source.segment == motion).count();
    assert_eq!(([2, 3, 5].map(count), count(4) > 10), ([1, 1, 1], true));
    let on_circle = |p: Vector3<f64>| ((p - Vector3::new(20.0, 20.0, 0.0)).norm() - 10.0).abs() < 1e-9;
    assert!(path.points().iter().filter(|p| p.source.segment == 4).all(|p| on_circle(p.position_mm)));
    assert_eq!((program.notes().spline_lines.clone(), program.notes().lines_in_splines), (vec![5, 6, 8], true));
    // The path lies straight between the points, as it counts.
    let before = end(4).arc_length_mm;
    assert!((end(5).arc_length_mm - before - 20.0).abs() < 1e-9);
}

#[test]
fn inline_forms_of_spline_motions_are_followed() {
    let forms = "&ACCESS RVP\nDEF p( )\nDECL FDAT FP1={TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE,POINT2[] \" \"}\nDECL LDAT LC={VEL 2,ACC 100,ORI_TYP \
                 #VAR,CIRC_TYP #BASE}\nSPTP XHOME WITH $VEL_AXIS[1]=SVEL_JOINT(100.0), $TOOL=STOOL2(FHOME), $BASE=SBASE(FHOME.BASE_NO)\nSPTP \
                 {X 0,Y 0,Z 0,A 0,B 0,C 180} WITH $TOOL = STOOL2(FP1), $BASE = SBASE(FP1.BASE_NO), $IPO_MODE = SIPO_MODE(FP1.IPO_FRAME)\nSLIN \
                 {X 9} WITH $VEL = SVEL_CP(0.02, , LC), $TOOL = STOOL2(FP1), $BASE = SBASE(FP1.BASE_NO), $LOAD = SLOAD(FP1.TOOL_NO), $ACC = \
                 SACC_CP(LC), $ORI_TYPE = SORI_TYP(LC), $APO = SAPO(LC), $JERK = SJERK(LC), $COLLMON_TOL_PRO[1] = USE_CM_PRO_VALUES(0) C_Spl\nEND\n";
    let program = parse(forms).unwrap();
    let path = coarse(&program);
    assert_eq!((path.len(), path.points()[1].position_mm), (2, Vector3::new(9.0, 0.0, 0.0)));
    assert_eq!(path.points()[1].feed_mm_per_min.map(f64::round), Some(1200.0));
    assert_eq!(program.notes().unlocated_lines, [5]);
    let with = |was: &str, is: &str| parse(&forms.replace(was, is)).unwrap_err();
    for (was, is, message) in [
        ("IPO_FRAME #BASE", "IPO_FRAME #TCP", "fixed tools ($IPO_MODE #TCP) are not followed"),
        ("ORI_TYP #VAR", "ORI_TYP #CONSTANT", "orientations that do not turn evenly along a motion ($ORI_TYPE)"),
        ("DECL LDAT LC=", "DECL LDAT LD=", "LC is not known"),
        ("DECL FDAT FP1=", "DECL FDAT FP2=", "FP1 is not known"),
        ("BASE_NO 2,", "", "expected TOOL_NO and BASE_NO in FDAT"),
        (
            " C_Spl\n",
            " C_Spl\nSLIN {X 5}\n",
            "motions without $BASE and $TOOL of their own behind one that has other ones (WITH)",
        ),
        (", $ACC = SACC_CP(LC)", ", $ACC = half(LC)", "functions that may do more than compute"),
    ] {
        let refused = with(was, is);
        assert!(refused.contains(message), "{refused}");
    }
    // As numbers, or set for all behind it, the frames are certain.
    let more = forms.replace(" C_Spl\n", " C_Spl\nBAS(#BASE,2)\nBAS(#TOOL,1)\nSLIN {X 5}\n");
    assert_eq!(coarse(&parse(&more).unwrap()).points()[2].position_mm.x, 5.0);
}

/// Statements behind a motion to a full pose, and how they are refused.
const REFUSED_OF_SPLINES: [(&str, &str); 24] = [
    ("SPL {X 1}\n", "p.src:2: `SPL {X 1}`: expected SPLINE before it"),
    ("ENDSPLINE\n", "p.src:2: `ENDSPLINE`: expected SPLINE before it"),
    ("SPLINE\nSPL {X 1}\n", "p.src:2: `SPLINE`: expected ENDSPLINE behind it"),
    (
        "SPLINE\nSPL {X 1}\nLIN {X 2}\nENDSPLINE\n",
        "p.src:4: `LIN {X 2}`: statements within SPLINE are not followed; expected SPL, SLIN, SCIRC and ENDSPLINE",
    ),
    (
        "SPLINE\nSPL {X 1}\n$OUT[1]=TRUE\nENDSPLINE\n",
        "p.src:4: `$OUT[1]=TRUE`: statements within SPLINE are not followed; expected SPL, SLIN, SCIRC and ENDSPLINE",
    ),
    (
        "SPLINE\nTIME_BLOCK START\nENDSPLINE\n",
        "p.src:3: `TIME_BLOCK START`: times, constant velocities and stops within SPLINE are not followed; expected segments alone",
    ),
    (
        "SPLINE\nSTOP WHEN PATH=5 IF $IN[1]\nENDSPLINE\n",
        "p.src:3: `STOP WHEN PATH=5 IF $IN[1]`: times, constant velocities and stops within SPLINE are not followed; expected segments alone",
    ),
    (
        "SPLINE\nCONST_VEL START=10\nENDSPLINE\n",
        "p.src:3: `CONST_VEL START=10`: times, constant velocities and stops within SPLINE are not followed; expected segments alone",
    ),
    (
        "SPLINE\nTRIGGER WHEN PATH=5 DELAY=0 DO $OUT[1]=TRUE\nENDSPLINE\n",
        "p.src:3: `TRIGGER WHEN PATH=5 DELAY=0 DO $OUT[1]=TRUE`: triggers on the way or at the end of a motion are not followed; expected \
         TRIGGER WHEN DISTANCE=0",
    ),
    (
        "SPLINE\nSPL {X 1} C_SPL\nENDSPLINE\n",
        "p.src:3: `SPL {X 1} C_SPL`: approximations within SPLINE are not followed; expected C_SPL behind ENDSPLINE alone",
    ),
    (
        "SPLINE\nSPL {X 1} WITH $BASE=$NULLFRAME\nENDSPLINE\n",
        "p.src:3: `SPL {X 1} WITH $BASE=$NULLFRAME`: $BASE and $TOOL of a segment are not followed; expected those behind SPLINE WITH",
    ),
    (
        "PTP_SPLINE\nSPTP {X 1}\nENDSPLINE\n",
        "p.src:2: `PTP_SPLINE`: splines of joints (PTP_SPLINE) are not followed; expected SPLINE, or SPTP by itself",
    ),
    (
        "SLIN_REL {X 1}\n",
        "p.src:2: `SLIN_REL {X 1}`: spline motions by steps are not followed; expected SLIN, SCIRC, SPTP and SPL to points",
    ),
    (
        "SPLINE\nSPL $POS_ACT\nENDSPLINE\n",
        "p.src:3: `SPL $POS_ACT`: expected a point, as where the robot is is not known before",
    ),
    ("SLIN {X 1} #TOOL\n", "p.src:2: `SLIN {X 1} #TOOL`: expected WITH or C_SPL behind the point, or nothing"),
    (
        "SLIN {X 1} WITH $ROTSYS=#BASE\n",
        "p.src:2: `SLIN {X 1} WITH $ROTSYS=#BASE`: other data behind WITH are not followed; expected $VEL, $ACC, $APO, $JERK, $BASE, $TOOL, \
         $LOAD, $ORI_TYPE, $CIRC_TYPE and what else inline forms set",
    ),
    (
        "SLIN {X 1} WITH $ORI_TYPE=#CONSTANT\n",
        "p.src:2: `SLIN {X 1} WITH $ORI_TYPE=#CONSTANT`: orientations that do not turn evenly along a motion ($ORI_TYPE) are not followed; \
         expected #VAR",
    ),
    (
        "SPLINE WITH $IPO_MODE=#TCP\n",
        "p.src:2: `SPLINE WITH $IPO_MODE=#TCP`: fixed tools ($IPO_MODE #TCP) are not followed; expected a tool that the robot carries",
    ),
    (
        "SLIN {X 1} WITH $VEL.CP\n",
        "p.src:2: `SLIN {X 1} WITH $VEL.CP`: expected = and a value behind each name of WITH",
    ),
    (
        "SLIN {X 1} WITH $ACC={CP 1\n",
        "p.src:2: `SLIN {X 1} WITH $ACC={CP 1`: expected a value with its brackets behind each = of WITH",
    ),
    (
        "$SPL_ORI_JOINT=#USE\n",
        "p.src:2: `$SPL_ORI_JOINT=#USE`: data that change splines ($SPL_…) are not followed; expected none",
    ),
    (
        "SCIRC {X 5,Y 5},{X 10} WITH $CIRC_TYPE=#PATH\n",
        "p.src:2: `SCIRC {X 5,Y 5},{X 10} WITH $CIRC_TYPE=#PATH`: circles that carry the orientation along ($CIRC_TYPE) are not followed; \
         expected $CIRC_TYPE=#BASE before it",
    ),
    (
        "SLIN {X 1} WITH $BASE={X 0,Y 0,Z 9,A 0,B 0,C 0}\nLIN {X 2}\n",
        "p.src:2: `SLIN {X 1} WITH $BASE={X 0,Y 0,Z 9,A 0,B 0,C 0}`: where {X 0,Y 0,Z 9,A 0,B 0,C 0} stands to the base before it is not \
         known; expected its pose in robot_program.bases of the process",
    ),
    (
        "IF $IN[1] THEN\nSPLINE\nSPL {X 1}\nENDSPLINE\nENDIF\n",
        "p.src:3: `SPLINE`: in IF of line 2, where it may be skipped or repeated; expected outside, where it runs once",
    ),
];

#[test]
fn what_would_change_splines_is_refused_by_line() {
    let pose = "SLIN {X 0,Y 0,Z 0,A 0,B 0,C 180}\n";
    for (source, message) in REFUSED_OF_SPLINES {
        assert_eq!(parse(&format!("{pose}{source}")).unwrap_err(), message);
    }
    // Also where routines and loops are followed.
    let pose = "DEF p( )\nINT I\nSLIN {X 0,Y 0,Z 0,A 0,B 0,C 180}\n";
    for (body, line) in [
        ("SPLINE\nFOR I=1 TO 2\nSPL {X 1}\nENDFOR\nENDSPLINE\n", "p.src:5: `FOR I=1 TO 2`: statements within SPLINE"),
        ("SPLINE\nsub( )\nENDSPLINE\n", "p.src:5: `sub( )`: statements within SPLINE"),
        ("FOR I=1 TO 2\nPTP_SPLINE\nSPTP {X 1}\nENDSPLINE\nENDFOR\n", "p.src:5: `PTP_SPLINE`: splines of joints"),
        ("FOR I=1 TO 2\nSPLINE\nSPL {X 1} C_DIS\nENDSPLINE\nENDFOR\n", "p.src:6: `SPL {X 1} C_DIS`: approximations"),
        ("FOR I=1 TO 2\nSPLINE\nagain:\nSPL {X 1}\nENDSPLINE\nENDFOR\n", "p.src:6: `again:`: statements within SPLINE"),
    ] {
        let refused = expanded(&format!("{pose}{body}END\nDEF sub( )\nEND\n")).map(|_| ()).unwrap_err();
        assert!(refused.starts_with(line), "{refused}");
    }
}

#[test]
fn frames_behind_with_are_those_of_their_motions() {
    let head = "$BASE={X 100,Y 0,Z 0,A 0,B 0,C 0}\nSPTP {X 0,Y 0,Z 0,A 0,B 0,C 180}\nSLIN {X 1,Y 2,Z 3} WITH $BASE={X 100,Y 0,Z 9,A 90,B 0,C 0}\n";
    let refused = "motions without $BASE and $TOOL of their own behind one that has other ones (WITH) are not followed; expected $BASE and \
                   $TOOL for all";
    let block = "SPLINE WITH $BASE={X 100,Y 5,Z 0,A 0,B 0,C 0}\nSPL {X 0,Y 0,Z 0}\nSLIN {X 1,Y 1}\nENDSPLINE\n";
    for (source, wanted) in [
        (head.to_owned(), Ok([-2.0, 1.0, 12.0])),
        (format!("{head}{block}"), Ok([1.0, 6.0, 0.0])),
        (format!("{head}{block}$BASE={{X 100,Y 0,Z 0,A 0,B 0,C 0}}\nLIN {{X 0,Y 0}}\n"), Ok([0.0, 0.0, 0.0])),
        (format!("{head}LIN {{X 0,Y 0,Z 0}}\n"), Err(4)),
        (format!("{head}{block}SLIN {{X 0}}\n"), Err(8)),
        (format!("{head}SPLINE\nSPL {{X 0}}\nENDSPLINE\n"), Err(5)),
    ] {
        match (parse(&source), wanted) {
            (Ok(program), Ok(wanted)) => {
                let path = coarse(&program);
                let last = path.points()[path.len() - 1].position_mm;
                assert!((last - Vector3::from(wanted)).norm() < 1e-9, "{last} {source}");
            }
            (Err(found), Err(line)) => {
                assert!(found.starts_with(&format!("p.src:{line}: ")) && found.ends_with(refused), "{found}");
            }
            (found, _) => panic!("{found:?}\n{source}"),
        }
    }
}

#[test]
fn any_program_with_splines_is_followed_or_refused() {
    let source = include_str!("../robot_programs/krl/17_splines.src");
    let forms = include_str!("../robot_programs/krl/18_forms.src");
    for text in [source, &forms[forms.len() - 1800..]] {
        for cut in 0..text.len() {
            for text in [text[..cut].to_owned(), format!("{}{}", &text[..cut], &text[cut + 1..])] {
                let _ = parse(&text);
                let _ = expanded(&text);
            }
        }
    }
}

/// SCIRC takes of two ways to turn the tool that on which the orientation of the auxiliary point lies ($CIRC_MODE.AUX_PT.ORI, #CONSIDER).
#[test]
fn circles_that_may_turn_the_tool_the_long_way_are_refused() {
    let circle = |via: &str, end: &str, more: &str| {
        parse(&format!("{GO}SCIRC {{X 10,Y 10{via}}},{{X 20,Y 0{end}}}{more}\n")).map(|_| ())
    };
    for (via, end, more) in [
        ("", "", ""),
        (",A 0,B 0,C 180", ",A 0,B 0,C 180", ",CA 90"),
        (",A 10", ",A 20", ""),
        ("", ",A 20", ""),
        (",A 20", ",A 20", " WITH $ACC.CP=1"),
        (",A 0.004", ",A -0.003", " WITH $CIRC_MODE.AUX_PT.ORI=#IGNORE"),
        (",E1 0", "", ""),
    ] {
        assert_eq!(circle(via, end, more), Ok(()), "{via} {end} {more}");
    }
    for (via, end, more) in [
        (",A 10", "", ""),
        (",A -5", ",A 20", ""),
        (",A 25", ",A 20", ""),
        (",B 10", ",A 20", ""),
        (",A 90", ",A 180", ""),
        (",A 10", ",A 20", ",CA 90"),
        (",A 10", ",A 20", " WITH $CIRC_MODE.AUX_PT.ORI=#INTERPOLATE"),
    ] {
        let refused = circle(via, end, more).unwrap_err();
        assert!(refused.contains("auxiliary point does not lie on the short turn"), "{via} {end} {more}: {refused}");
    }
}

#[test]
fn corrected_splines_keep_their_blocks() {
    let source = format!(
        "{GO}SPLINE WITH $VEL.CP=0.02\n  SLIN {{X 20.0}} WITH $ACC.CP=1 ; in\n  SPL {{X 30.0,Y 5.0}} ; curve\n  SPL {{X 40.0}}\nENDSPLINE\nSLIN {{X \
         60.0}} WITH $VEL.CP=0.01 ; out\nSLIN {{X 80.0}} C_DIS\n"
    );
    let program = parse(&source).unwrap();
    let path = program.toolpath(Sampling::new(0.01, 10.0).unwrap()).unwrap();
    let bent = |p: Vector3<f64>| p + Vector3::z() * 0.01 * p.x * (80.0 - p.x);
    let wanted: Vec<Vector3<f64>> = path.positions_mm().into_iter().map(bent).collect();
    let written =
        program.rewrite(&path, &wanted, None, WriteOptions::with_decimals(NumberFormat::new(3, 4).unwrap())).unwrap();
    // Points that are put in have no approximation within the block, and C_SPL outside.
    let expected = format!(
        "{GO}SPLINE WITH $VEL.CP=0.02\n  SLIN {{X 10.000,Z 7.000}} WITH $ACC.CP=1\n  SLIN {{X 20.0,Z 12.000}} WITH $ACC.CP=1 ; in\n  SPL {{X \
         30.0,Y 5.0,Z 15.000}} ; curve\n  SPL {{X 40.0,Z 16.000}}\nENDSPLINE\nSLIN {{X 50.000,Z 15.000}} WITH $VEL.CP=0.01 C_SPL\nSLIN {{X \
         60.0,Z 12.000}} WITH $VEL.CP=0.01 ; out\nSLIN {{X 70.000,Z 7.000}} C_DIS\nSLIN {{X 80.0,Z 0.000}} C_DIS\n"
    );
    assert_eq!(String::from_utf8_lossy(written.bytes()), expected);
    let back = written.read_back().unwrap().positions_mm();
    assert!(back.iter().zip(&wanted).all(|(back, wanted)| (back - wanted).norm() < 1e-3));
    let same =
        program.rewrite(&path, &path.positions_mm(), None, WriteOptions::with_decimals(program.own_format())).unwrap();
    assert_eq!(same.bytes(), source.as_bytes());
}

#[test]
fn circles_in_blocks_stay_circles_or_become_lines() {
    let source = format!(
        "{GO}SPLINE\n  SCIRC {{X 10.0,Y 10.0}},{{X 20.0,Y 0.0}} WITH $CIRC_TYPE=#BASE,$ACC.CP=1 ; half\nENDSPLINE\nSCIRC {{X 30.0,Y \
         10.0}},{{X 40.0,Y 0.0}} WITH $CIRC_MODE.AUX_PT.ORI=#CONSIDER C_SPL\n"
    );
    let program = parse(&source).unwrap();
    let path = program.toolpath(Sampling::default()).unwrap();
    let write = |by: &dyn Fn(f64) -> Vector3<f64>, orientations: Option<&[Orientation]>| {
        let wanted: Vec<Vector3<f64>> = path.points().iter().map(|p| p.position_mm + by(p.source.parameter)).collect();
        let writing = WriteOptions { tolerance_mm: 0.005, ..WriteOptions::with_decimals(program.own_format()) };
        let written = program.rewrite(&path, &wanted, orientations, writing).unwrap();
        let back = written.read_back().unwrap().positions_mm();
        assert!(back.iter().zip(&wanted).all(|(back, wanted)| (back - wanted).norm() < 0.006));
        String::from_utf8(written.bytes().to_vec()).unwrap()
    };
    let shifted = write(&|_| Vector3::new(1.0, 2.0, 3.0), None);
    assert_eq!((shifted.matches("SCIRC {").count(), shifted.matches("SLIN {").count()), (2, 0), "{shifted}");
    assert!(shifted.contains("  SCIRC {X 11.000,Y 12.000},{X 21.000,Y 2.000} WITH $CIRC"), "{shifted}");
    // What WITH says of circles is none of lines.
    let wavy = write(&|t| Vector3::z() * 0.3 * (40.0 * t).sin(), None);
    let lines: Vec<&str> = wavy.lines().filter(|line| line.trim_start().starts_with("SLIN")).collect();
    assert!(lines.len() > 10 && lines.iter().all(|line| !line.contains("$CIRC")), "{wavy}");
    let inner = wavy.lines().skip(2).take_while(|line| *line != "ENDSPLINE");
    assert!(inner.clone().all(|line| line.starts_with("  S") && line.contains("$ACC.CP=1")), "{wavy}");
    assert!(inner.clone().all(|line| !line.contains("C_SPL")), "{wavy}");
    let behind = wavy.lines().skip_while(|line| *line != "ENDSPLINE").skip(1);
    assert!(behind.clone().all(|line| line.ends_with(" C_SPL")), "{wavy}");
    // A circle is not written where a tool that is turned might go the long way.
    let turned: Vec<Orientation> = path
        .points()
        .iter()
        .enumerate()
        .map(|(k, point)| {
            let Some(Orientation::Platform(platform)) = point.orientation else { panic!() };
            Orientation::Platform(UnitQuaternion::from_scaled_axis(Vector3::x() * 1e-5 * k as f64) * platform)
        })
        .collect();
    let turned = write(&|_| Vector3::z(), Some(&turned));
    assert!(turned.matches("SLIN {").count() > 2 && !turned.contains("SCIRC"), "{turned}");
    let own: Vec<Orientation> = path.points().iter().map(|point| point.orientation.unwrap()).collect();
    assert_eq!(write(&|_| Vector3::zeros(), Some(&own)), source);
}

#[test]
fn blocks_in_loops_and_routines_are_followed() {
    let source = "DEF p( )\nINT I\nPOS W\nSPTP {X 0,Y 0,Z 0,A 0,B 0,C 180}\nFOR I=1 TO 2\nW={X 0,Y 0,Z 0,A 0,B 0,C 180}\nW.X=10*I\nSPLINE WITH \
                  $VEL.CP=0.02\n  SPL W\n  SLIN {Y 5} WITH $ACC.CP=1\n  SCIRC {X 5,Y 15},{X 0,Y 5}\nENDSPLINE C_SPL\nENDFOR\nround( )\nround( )\nEND\nDEF \
                  round( )\nSPLINE\n  SPL {X 1,Y 1,Z 1,A 0,B 0,C 180}\n  SPL {X 2,Y 1,Z 1,A 0,B 0,C 180} ; last\nENDSPLINE\nEND\n";
    let program = expanded(source).unwrap();
    let written = String::from_utf8_lossy(program.source()).into_owned();
    assert!(
        written.contains("SPLINE WITH $VEL.CP=0.02\n  SPL {X 20,Y 0,Z 0,A 0,B 0,C 180}\n  SLIN {Y 5}"),
        "{written}"
    );
    let path = coarse(&program);
    let ends = path.points().iter().filter(|point| point.source.parameter == 1.0);
    assert_eq!(
        ends.map(|point| point.position_mm.map(|c| c.round() + 0.0).into()).collect::<Vec<[f64; 3]>>()[1..],
        [
            [10.0, 0.0, 0.0],
            [10.0, 5.0, 0.0],
            [0.0, 5.0, 0.0],
            [20.0, 0.0, 0.0],
            [20.0, 5.0, 0.0],
            [0.0, 5.0, 0.0],
            [1.0, 1.0, 1.0],
            [2.0, 1.0, 1.0],
            [1.0, 1.0, 1.0],
            [2.0, 1.0, 1.0]
        ]
    );
    // Lines of the program as posted.
    assert_eq!(program.notes().spline_lines, [9, 9, 19, 20, 19, 20]);
    let Calls::Stay { program: same, .. } = moved(&program, |_| 0.0) else { panic!() };
    assert_eq!(String::from_utf8(same).unwrap(), source);
    let Calls::Stay { program: kept, .. } = moved(&program, |k| if k > 10 { 0.1 } else { 0.0 }) else { panic!() };
    let kept = String::from_utf8(kept).unwrap();
    assert!(kept.contains("SPLINE\n  SPL {X 1,Y 1,Z 1.100,A 0,B 0,C 180}\n"), "{kept}");
}

/// What leads on from where the robot is, or acts on data of the motions behind it, is not passed over.
#[test]
fn what_begins_where_the_robot_is_is_refused() {
    for stays in
        ["PTP $AXIS_ACT", "LIN $POS_ACT C_DIS", "SLIN $POS_ACT", "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[1]=TRUE"]
    {
        assert_eq!(parse(&format!("{GO}{stays}\nLIN {{X 30}}\n")).map(|_| ()), Ok(()), "{stays}");
    }
    for refused in [
        "LIN $POS_ACT:{X 0,Y 0,Z -50,A 0,B 0,C 0}",
        "PTP $POS_ACT:{X 0,Y 0,Z -50,A 0,B 0,C 0} C_PTP",
        "LIN $POS_ACT + 5",
        "LIN_REL $POS_ACT",
        "PTP $AXIS_ACT LIN {X 50}",
        "CIRC {X 5,Y 5},$POS_ACT",
        "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $BASE={X 0,Y 0,Z 9,A 0,B 0,C 0}",
        "TRIGGER WHEN DISTANCE=0+1 DELAY=0 DO $OUT[1]=TRUE",
        "$CIRC_MODE.AUX_PT.ORI=#INTERPOLATE",
    ] {
        let error = parse(&format!("{GO}{refused}\nLIN {{X 30}}\n")).expect_err(refused);
        assert!(error.starts_with("p.src:2: `"), "{refused}: {error}");
    }
    // A speed that is computed is not its first number.
    let feed = |with: &str| {
        coarse(&parse(&format!("{GO}SLIN {{X 10}} WITH $VEL={{CP {with}}}\n")).unwrap()).points()[1].feed_mm_per_min
    };
    assert_eq!((feed("0.05"), feed("0.05,ORI1 100")), (Some(3000.0), Some(3000.0)));
    assert_eq!((feed("0.05*0.2"), feed("0.05-0.04,ORI1 100")), (None, None));
}
