g21 g90 g17
g0 x0 y0 z5
g1 z-1 f100 (plunge)
g1 x12.5 y3.25 f450
g3 x2.5 y3.25 i-5 j0
g0 z5
m30
