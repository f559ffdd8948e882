; local_and_shift.nc:5:1: `G52`: G52 and G92 in force together mean different things to different controls; expected one of them
G21 G90 G17 F100
G0 X0 Y0 Z5
G92 X5
G52 X1
