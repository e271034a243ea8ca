"""Counts of selection and grouping, which stay in the memory of a GPU: places in (16,) i8."""

N_COUNTS = 16

# Numbers that other stages and the CPU read.
FIRST_NEW = 0  # impacts before the last selection, so the index of the first new one
IMPACTS = 1  # impacts in the zones
NEW = 2  # impacts of the last selection that found room
NEEDED_IMPACTS = 3  # room that the impacts of the zones and all selected ones need
ZONES = 4  # zones
TO_SOLVE = 5  # zones that have to be solved
OF_SIZE = 6  # three numbers: how many of the zones to solve are small, middle and large
ZONE_IMPACTS = 9  # impacts in zones, without those that have pinned vertices only
ZONE_VERTICES = 10  # unpinned vertices of the zones

# Numbers that only one of the two launches uses.
STARTS = 11  # places where the impacts or the vertices of a zone begin
LEFT_OUT = 12  # impacts that have pinned vertices only
FOUND_VERTICES = 13  # unpinned vertices of the impacts found
TAKEN = 14  # impacts that were selected, with or without room
