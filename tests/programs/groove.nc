%
O0002 (50 mm groove)
N10 G21 G90 G17 G54 ; metric, absolute
N20 G0 X25. Y0. Z5.

N30 S3000 M3
N40 G1 Z0. F200
N50 G3 X25. Y0. I-25. J0. F600 (full circle)
N60 G0 Z5.
N70 M30
%
