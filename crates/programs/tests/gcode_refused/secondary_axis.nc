; secondary_axis.nc:4:7: `W3`: secondary axes are not supported; expected X, Y and Z only
G21 G90 G17 F100
G0 X0 Y0 Z5
G1 X5 W3
