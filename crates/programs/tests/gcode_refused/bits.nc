; --expand bits.nc:4:1: `#1=12 AND 4`: not an expression that can be evaluated; expected AND, OR and XOR of comparisons
G21 G90 G17 F100
G0 X0 Y0 Z5
#1=12 AND 4
