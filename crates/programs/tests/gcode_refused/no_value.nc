; --expand no_value.nc:4:4: `X#7`: a variable without a value; expected one that the program has assigned before
G21 G90 G17 F100
G0 X0 Y0 Z5
G1 X#7
