; probe.nc:4:1: `G38.2`: goes on until something is touched, so that the program does not say where it ends; expected G0 or G1 to a position, and what measures in a program of its own
G21 G90 G17 F100
G0 X0 Y0 Z5
G38.2 Z-10 F50
