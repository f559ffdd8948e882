%
(where the tool is is known from line 7 on)
G21 G90
G1 X12. F300
G91 G1 Y2.
G90 G0 X0. Y0.
G1 Z-1. F100 (now Z as well)
G1 X20. F300
Y20.
G28 Z0
G0 X5. Y5. (left as it is)
G0 Z2.
G1 Z-1.
X15. Y15.
M30
%
