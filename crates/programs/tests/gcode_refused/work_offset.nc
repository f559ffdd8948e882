; work_offset.nc:4:5: `X5`: how G55 stands to the work offset before it is not known; expected its zero in [gcode] of the process file, or G10 L2 for both
G21 G90 G17 F100
G0 X0 Y0 Z5
G55 X5
