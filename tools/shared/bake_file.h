// The file of a bake: every array with its name, shape, unit and meaning (io/described_file.h). gi/probes/README.md lists them.
#pragma once

#include <string>

#include "gi/probes/bake.h"
#include "io/described_file.h"

namespace plumb::cli {

inline const io::Kind bake_kind{"probe bake", 1, 1};

// with_alpha: the un-truncated transport, too. Large arrays are lent: the bake must outlive the file.
io::DescribedFile bake_file(const probes::Bake& bake, const std::string& scene, bool with_alpha);

// Throws InputError that names the file: an array that is missing or of another type or shape, lists that do not fit each other.
void check_bake(const io::DescribedFile& file);

// Its clusters. Throws InputError for an array that is missing or of another type or shape.
probes::FlatClusters flat_clusters_of(const io::DescribedFile& file);
// Its spatial receivers, as grid, receivers, supports and flat clusters; none in a file that has none. Throws as flat_clusters_of() does, and for a grid
// that is none.
probes::Spatial spatial_of(const io::DescribedFile& file);

// Throws InputError where the sky, or its absence, asks for another solution of rays that meet nothing than the bake has.
void check_sky(const io::DescribedFile& file, const Scene& scene);

}  // namespace plumb::cli
