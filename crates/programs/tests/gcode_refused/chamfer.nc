; chamfer.nc:4:8: `C2.5`: C with a feed is an axis on some controls and an angle or a chamfer on others; expected a G0 with C before, or the line without it
G21 G90 G17 F100
G0 X0 Y0 Z5
G1 X20 C2.5
