; --expand machine_variable.nc:4:4: `X#5041`: depends on the state of the machine; expected variables #1 to #999 and names that the program assigns
G21 G90 G17 F100
G0 X0 Y0 Z5
G1 X#5041
