// Writes the Cornell box and its receivers into a folder, for pieprobe:
//
//   cornell_files FOLDER      cornell.obj, cornell.mtl, points.csv (500), edges.csv (200), inner.csv

#include "tests/support/cornell.h"

#include <cstdio>
#include <exception>
#include <fstream>

int main(int count, char** arguments) {
    try {
        if (count != 2) {
            std::fputs("usage: cornell_files FOLDER\n", stderr);
            return 2;
        }
        const std::filesystem::path folder = arguments[1];
        std::filesystem::create_directories(folder);
        pie::test::writeCornell(folder);
        std::ofstream(folder / "points.csv") << pie::test::pointsCsv(pie::test::cornellPoints(500));
        std::ofstream(folder / "edges.csv") << pie::test::pointsCsv(pie::test::cornellEdgeVertices());
        std::ofstream(folder / "inner.csv") << pie::test::pointsCsv(pie::test::cornellInnerVertices());
        return 0;
    } catch (const std::exception& problem) {
        std::fprintf(stderr, "cornell_files: %s\n", problem.what());
        return 1;
    }
}
