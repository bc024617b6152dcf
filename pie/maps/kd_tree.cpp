// kd_tree
