; machine_coordinates_arc.nc:4:4: `G53`: machine coordinates with an arc are not supported; expected G53 with G0 or G1
G21 G90 G17 F100
G0 X0 Y0 Z5
G2 G53 X5
