0 begin pgm small mm
1 tool call 1 z s2000 f300
2 l x0 y0 z5 r0 fmax m3
3 l z-1 f100
4 l x12.5 y3
5 cc x12.5 y13
6 c x22.5 y13 dr+
7 l z20 fmax
8 end pgm small mm
