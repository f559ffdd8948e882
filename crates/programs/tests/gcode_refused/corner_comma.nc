; corner_comma.nc:4:4: `X20,R2.5`: corners that the control rounds or bevels (,R ,C) are not supported; expected the corner written as moves
G21 G90 G17 F100
G0 X0 Y0 Z5
G1 X20,R2.5
