#pragma once
// What the plug-ins for .bsp and .map have in common: options in, a level node or one line of what is wrong out.

#include "osgPlugins/osgpie/level_node.h"
#include "pie/core/result.h"
#include "pie/engine/settings.h"

#include <osgDB/ReaderWriter>

#include <optional>
#include <span>
#include <string>

namespace osgpie {

class LevelReader : public osgDB::ReaderWriter {
public:
    /// Extension without the dot; it also stands in front of messages.
    LevelReader(const std::string& extension, const std::string& description);

    ReadResult readObject(const std::string& file, const Options* options) const override;
    ReadResult readObject(std::istream& stream, const Options* options) const override;
    ReadResult readNode(const std::string& name, const Options* options) const override;
    ReadResult readNode(std::istream& stream, const Options* options) const override;
    [[nodiscard]] const char* libraryName() const override { return "osgpie"; }
    [[nodiscard]] const char* className() const override { return className_.c_str(); }

protected:
    /// What another reader says of files that belong to it; nothing: the file is ours. `file` exists.
    [[nodiscard]] virtual std::optional<ReadResult> readForeign(const std::string& file, const Options* options) const;
    [[nodiscard]] virtual std::optional<ReadResult> readForeign(std::istream& stream, std::span<const char> bytes,
                                                                const Options* options) const;
    [[nodiscard]] const std::string& prefix() const { return prefix_; }

private:
    std::string extension_, prefix_, className_;

    [[nodiscard]] pie::Result<pie::engine::Settings> readSettings(const Options* options) const;
    [[nodiscard]] ReadResult failure(const pie::Error& error) const;
    [[nodiscard]] ReadResult finish(pie::Result<osg::ref_ptr<LevelNode>> node) const;
};

} // namespace osgpie
