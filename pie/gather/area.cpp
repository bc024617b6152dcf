// area
