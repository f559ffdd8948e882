; --expand two_letters.nc:4:10: `I1 I2`: second I word on the line; expected one
G21 G90 G17 F100
G0 X0 Y0 Z5
G65 P100 I1 I2
