; cutter_compensation.nc:4:1: `G41`: cutter radius compensation is not followed as the control makes it; expected the path of the tool centre with G40, or cutter_compensation = "off" in [gcode] of the process file, which writes it
G21 G90 G17 F100
G0 X0 Y0 Z5
G41 D1 X5
