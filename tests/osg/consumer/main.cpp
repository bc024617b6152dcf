// An application with a scene of its own that adds a level to it, traces light without a window and asks for it.

#include <osgPlugins/osgpie/load.h>

#include <osg/Group>

#include <iostream>
#include <numeric>

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    pie::engine::Settings settings;
    if (const auto set = settings.setOptions("photons_from_light=2000 accumulation_frames=2"); !set) {
        std::cerr << set.error().message() << "\n";
        return 1;
    }
    const auto level = osgpie::loadLevelNode(argv[1], settings);
    if (!level) {
        std::cerr << level.error().message() << "\n";
        return 1;
    }
    const osg::ref_ptr<osg::Group> scene = new osg::Group;
    scene->addChild(*level);

    pie::engine::Engine& engine = (*level)->engine();
    while (engine.advance()) {}
    std::vector<std::uint32_t> all(engine.receivers().points.size());
    std::iota(all.begin(), all.end(), 0U);
    std::vector<pie::Rgb> light(all.size());
    engine.irradiance(all, light);
    double sum = 0;
    for (const pie::Rgb& e : light) sum += static_cast<double>(e.x + e.y + e.z) / 3;
    std::cout << "light: " << engine.lights().summary() << "\nreceivers: " << all.size()
              << "\nmean: " << sum / static_cast<double>(all.size()) << "\nradius: " << scene->getBound().radius()
              << std::endl;
    return 0;
}
