; checksum.nc:4:7: `X5*36`: line checksums are not supported; expected the line without `*` and the number after it
G21 G90 G17 F100
G0 X0 Y0 Z5
N3 G1 X5*36
