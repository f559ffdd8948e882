; rotary_axis.nc:5:7: `A30`: turns A, which stood at 0; expected rotary axes that keep one value, or [[gcode.rotary]] in the process file, which says what A turns
G21 G90 G17 F100
G0 X0 Y0 Z5
G0 A0
G1 X5 A30
