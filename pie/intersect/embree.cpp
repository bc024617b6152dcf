// embree
