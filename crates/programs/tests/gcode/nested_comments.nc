($Load("the mill first.") )
($PartSize(42, 12, 2) )
%
O0023 (A (B))
N10 G28 G91 Z0
N15 G90
N20 X0 Y0 Z10
N30 G1 Z-1 F60 (in (deep) )
N40 X8
N50 Y8
N60 G0 Z10
N70 M30
