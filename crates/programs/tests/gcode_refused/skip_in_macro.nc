; --expand skip_in_macro.nc:7:5: `G31 Z[#1-10] F50`: goes on until something is touched, so that the program does not say where it ends; expected G0 or G1 to a position, and what measures in a program of its own
G21 G90 G17 F100
G0 X0 Y0 Z5
#1=2.5
IF [#1 GT 2] GOTO 20
G31 Z-99 (not run)
N20 G31 Z[#1-10] F50
#100=#5063
