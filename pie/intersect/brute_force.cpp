// brute_force
