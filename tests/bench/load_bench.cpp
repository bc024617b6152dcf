// Reads a level some times through OSG's registry and prints the milliseconds of each read:
//     load_bench LEVEL [TIMES] [OPTIONS]
// Which plug-in reads is up to OSG_LIBRARY_PATH; doc/scripts/load-times runs it in turns with ours and with OSG's own.

#include <osgDB/ReadFile>

#include <fmt/format.h>

#include <chrono>
#include <cstdlib>

int main(int argc, char** argv) {
    if (argc < 2) {
        fmt::print(stderr, "usage: load_bench LEVEL [TIMES] [OPTIONS]\n");
        return 2;
    }
    const int times = argc > 2 ? std::atoi(argv[2]) : 1;
    const osg::ref_ptr options = new osgDB::Options(argc > 3 ? argv[3] : "");
    options->setObjectCacheHint(osgDB::Options::CACHE_NONE);
    for (int i = 0; i < times; ++i) {
        const auto start = std::chrono::steady_clock::now();
        const osg::ref_ptr<osg::Node> node = osgDB::readRefNodeFile(argv[1], options);
        const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - start;
        if (!node) return 1;
        fmt::print("{:.3f}\n", taken.count());
    }
    return 0;
}
