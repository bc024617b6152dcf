// bsp_tree
