; origin_of_lathes.nc:4:5: `X50`: coordinate on a line with G50, which is no motion; expected the coordinate on a line of its own
G21 G90 G17 F100
G0 X0 Y0 Z5
G50 X50 Z20
