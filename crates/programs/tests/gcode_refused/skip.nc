; skip.nc:5:5: `G31`: goes on until something is touched, so that the program does not say where it ends; expected G0 or G1 to a position, and what measures in a program of its own
G21 G90 G17
G0 X0 Y0 Z5
(G31 in a comment is none)
N10 G31 Z-10. F50.
G1 Z-1. F300.
