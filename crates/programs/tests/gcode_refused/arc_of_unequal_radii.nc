; arc_of_unequal_radii.nc:4:1: `G2`: arc starts 5.0000 mm and ends 5.0249 mm from its centre; expected equal radii to 0.005 mm or 0.1 %
G21 G90 G17 F100
G0 X0 Y0 Z5
G2 X10 Y0.5 I5
