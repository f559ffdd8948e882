//! Tools in comments of programs, on lines as posts write them.

use kinetostat_programs::{
    ToolDescription,
    gcode::{LengthUnit, tool_comments},
};

/// What a program in mm, or in inches, says about its tools in words: number, name, diameter, corner, point and teeth.
fn tools(program: &str, unit: LengthUnit) -> Vec<String> {
    let words = |tool: ToolDescription| {
        let shape =
            tool.shape.map_or("?".into(), |shape| shape.map_or_else(str::to_uppercase, |own| own.name().into()));
        let mut words = format!("{} {shape}", tool.number);
        for (name, value) in [("D", tool.diameter_mm), ("R", tool.corner_radius_mm), ("A", tool.point_angle_deg)] {
            words += &value.map_or(String::new(), |value| format!(" {name}{}", (value * 1e4).round() / 1e4));
        }
        words + &tool.teeth.map_or(String::new(), |teeth| format!(" Z{teeth}"))
    };
    tool_comments(program.as_bytes(), Some(unit)).into_iter().map(words).collect()
}

#[test]
fn tools_are_read_as_posts_write_them() {
    let inch = LengthUnit::Inch;
    for (comment, unit, expected) in [
        (
            "(T2 D=3.175 CR=0 - ZMIN=-7.366 - flat end mill)       ; Tool 2 selected (3.175mm flat end mill)",
            LengthUnit::Millimetre,
            "2 flat end mill D3.175",
        ),
        ("(  T2 D=6.35 CR=0 - ZMIN=-19.15 - flat end mill )", LengthUnit::Millimetre, "2 flat end mill D6.35"),
        ("(T1 D=3.175 CR=0. - ZMIN=-4.2 - FLAT END MILL)", LengthUnit::Millimetre, "1 flat end mill D3.175"),
        ("(T1  D=0.125 CR=0.015 - ZMIN=-1. - BULLNOSE END MILL)", inch, "1 bull-nose end mill D3.175 R0.381"),
        ("(T18 D=0.25 CR=0.125 - ZMIN=0.4284 - ball end mill)", inch, "18 ball end mill D6.35"),
        ("(T9 D=2.5 CR=0. TAPER=118deg - ZMIN=-4.751 - taladrar)", LengthUnit::Millimetre, "9 ? D2.5 R0 A118"),
        ("(T34  D=1.7 CR=0 TAPER=118deg - ZMIN=-26.411 - drill)", LengthUnit::Millimetre, "34 drill D1.7 A118"),
        ("N5 ;  #7 D=7 TAPER=118deg - ZMIN=-30.103 - ZMAX=+15 - drill", LengthUnit::Millimetre, "7 drill D7 A118"),
        ("4 ;T3 D=+7 CR=+0 TAPER=118deg - ZMIN=-15 - drill", LengthUnit::Millimetre, "3 drill D7 A118"),
        (
            "(T1  D=4. CR=0. TAPER=90deg - ZMIN=-1. - spot drill - 4mm Spot Drill)",
            LengthUnit::Millimetre,
            "1 drill D4 A90",
        ),
        ("(T9  D=6. CR=0. TAPER=45deg - ZMIN=-1.3 - chamfer mill - 6mm)", LengthUnit::Millimetre, "9 CHAMFER MILL D6"),
        ("(T1 ID=I431 D=2. CR=0.006 - ZMIN=-0.2224 - FACE MILL)", inch, "1 bull-nose end mill D50.8 R0.1524"),
        (
            "(T6  Spiral O Metal 3.175*12mm  Makera    D=3.175 CR=0. - ZMIN=-26. - flat end mill)",
            LengthUnit::Millimetre,
            "6 flat end mill D3.175",
        ),
        ("(T2  D=0.25 CR=0. - ZMIN=-0.0311 - 1-4 FLAT)", inch, "2 ? D6.35 R0"),
        ("(  Tool 1: Flat End Mill 2 Flutes, Diam = 6.35mm, Len = 19.05mm)", inch, "1 flat end mill D6.35 Z2"),
        ("(  Tool #2: Ball End Mill 3 Flutes, Diam = 6mm, Len = 20.00mm)", inch, "2 ball end mill D6 Z3"),
        ("(T2 = End Mill {0.5 inches})", LengthUnit::Millimetre, "2 flat end mill D12.7"),
        ("(5 = End Mill {0.2500 inch} UpDown)", LengthUnit::Millimetre, "5 flat end mill D6.35"),
        ("(T2 = End Mill {6 insert})", LengthUnit::Millimetre, "2 flat end mill"),
        ("(2 = V-Bit {60 deg 12 mm})", inch, "2 V-BIT D12"),
        ("(2 = V-Bit {60 deg})", inch, "2 V-BIT"),
        ("(T2 = Spiral Bit {0.5 inches})", inch, "2 ? D12.7"),
        ("( T212 |    3. FLAT ENDMILL | H0 )", LengthUnit::Millimetre, "212 flat end mill D3"),
        ("( T1 | 1/4 FLAT ENDMILL | H1 | D1 | TOOL DIA. - .25 )", inch, "1 flat end mill D6.35"),
        (
            "( T3 | 1/2 TAPERED ENDMILL | H3 )\n(T4 | 3/8 BULL ENDMILL 1/16 RAD | H4)",
            inch,
            "4 bull-nose end mill D9.525",
        ),
        ("( 1/16 FLAT ENDMILL TOOL - 1 DIA. OFF. - 1 LEN. - 1 DIA. - .0625)", inch, "1 flat end mill D1.5875"),
    ] {
        assert_eq!(tools(comment, unit), [expected], "{comment}");
    }
}

#[test]
fn what_is_no_tool_is_none() {
    for comment in [
        "(TC: 5mm Endmill)",
        "(T7 ROUGHING)",
        "T2 M6 (Load 3mm Ball End Mill)",
        "(T1 | 10MM HARVEY 4FL | H1)",
        "X=(R1+2)",
        "(T1 D=)",
        "(T D=6. - flat end mill)",
        "(1 = x)",
        "(T1 D=10,5 CR=0. - flat end mill)",
        "(T1 D=10mm - flat end mill)",
        "(T1 D=10. CR=0,5 - flat end mill)",
        "(  Tool 1: Flat End Mill 2 Flutes, Diam = 6,35mm, Len = 19mm)",
        "(T1 | 1 1/2 FLAT ENDMILL | H1)",
        "( 1/16 FLAT ENDMILL TOOL - 1 DIA. OFF. - 1 LEN. - 1 DIA. - 0,0625)",
        "(TOOL/MILL,3.17, 0.00, 0.00, 0.00)",
        ")(",
        "(T99999999999 D=6. CR=0. - flat end mill)",
    ] {
        assert!(tools(comment, LengthUnit::Millimetre).is_empty(), "{comment}");
    }
    // Said again it is the same; said otherwise it is kept, so that this is seen. Without a unit there is no length.
    let twice = "(T1 D=6. CR=0. - flat end mill)\n";
    assert_eq!(tools(&(twice.to_owned() + twice), LengthUnit::Millimetre).len(), 1);
    assert_eq!(tools(&(twice.to_owned() + &twice.replace('6', "8")), LengthUnit::Millimetre).len(), 2);
    assert_eq!(tool_comments(twice.as_bytes(), None)[0].diameter_mm, None);
}
