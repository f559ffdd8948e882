; spline.nc:4:4: `X1`: this motion is not supported; expected G0, G1, G2 or G3
G21 G90 G17 F100
G0 X0 Y0 Z5
G5 X1 Y1 I0 J3 P0 Q-3
