; two_axes.nc:4:7: `X6`: second X word on the line; expected one
G21 G90 G17 F100
G0 X0 Y0 Z5
G1 X5 X6
