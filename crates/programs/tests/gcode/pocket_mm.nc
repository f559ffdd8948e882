%
O0001 (POCKET 40x30, 8 mm end mill)
(plain metric program with comments and line numbers)
N10 G17 G21 G40 G49 G80 G90 G94
N20 T1 M6
N30 S8000 M3
N40 G0 X0 Y0
N50 G43 H1 Z25.0
N60 Z2.0 (clearance)

N70 G1 Z-1.5 F200
N80 X40.0 F800
N90 Y30.0
N100 X0.0
N110 Y0.0 ; back at the start
N120 G0 Z25.0
N130 M5
N140 M30
%
