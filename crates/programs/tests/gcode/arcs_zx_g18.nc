(arcs in the ZX plane: a cylinder milled across)
G21 G90 G18
G0 X-10. Y0. Z0.
G1 F500.
G2 X10. Z0. I10. K0.
G1 Y1.
G3 X-10. Z0. I-10. K0.
G1 Y2.
G2 X0. Z10. I10. K0.
G17
G1 X0. Y0. Z20.
M30
