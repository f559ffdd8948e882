g20 g90
g0x0y0z.5
g83x1.y.5z-.75r.1q.1f4
x2.
g80
g0z1.
