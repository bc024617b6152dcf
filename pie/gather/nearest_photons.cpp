// nearest_photons
