; open_comment.nc:4:7: `(no end`: comment is not closed; expected `)` on the same line
G21 G90 G17 F100
G0 X0 Y0 Z5
G1 X5 (no end
