; --expand no_subprogram.nc:4:1: `M98 P4711`: subprogram 4711 is neither in the file nor beside it; expected O4711, a file of this name, or 4711 in calls_kept of [gcode] if it moves nothing
G21 G90 G17 F100
G0 X0 Y0 Z5
M98 P4711
