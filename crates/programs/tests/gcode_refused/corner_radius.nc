; corner_radius.nc:4:8: `R2.5`: arc word on a line that is no arc; expected G2 or G3 in force
G21 G90 G17 F100
G0 X0 Y0 Z5
G1 X20 R2.5
