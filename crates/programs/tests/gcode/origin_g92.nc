(the place where the program begins is called 10, 10, 5)
G21 G90
G92 X10 Y10 Z5
G0 Z4
G1 Z-1 F150
G1 X20
Y30
G92 X0 Y0 (a second part beside it)
G1 X15
Y12
G0 Z5
