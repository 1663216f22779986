// SPDX-License-Identifier: MIT
/// `watersky map FLIGHT -o OUT`: the main job.
#include "cli.hpp"
#include "flight_options.hpp"
#include "watersky/geodesy/projection.hpp"
#include "watersky/mapping/mapping.hpp"
#include "watersky/products/alignment_run.hpp"
#include "watersky/products/map_products.hpp"
#include "watersky/products/products.hpp"
#include "watersky/products/run_json.hpp"
#include "watersky/vision/opencl.hpp"

namespace watersky::cli {

namespace {

struct Options {
  FlightOptions flight;
  std::string out, projection, continued;
  SegmentationChoice segmentation;
  bool overwrite = false;
  bool no_align = false;
  bool smooth = false;
  field::SmoothingParameters smoothing;
  AlignParameters align;
  MappingParameters parameters;
};

/// What the flight's own images say of it; nullptr when that was not wanted.
Result<std::shared_ptr<const AlignmentRun>> alignment_of(const Flight& flight, const Options& o,
                                                         const MappingOptions& mapping,
                                                         const Progress& progress) {
  if (o.no_align) return std::shared_ptr<const AlignmentRun>();
  AlignOptions options{
      .parameters = o.align, .threads = mapping.threads, .camera_mask = mapping.camera_mask};
  options.parameters.align_max_pose_gap_s = mapping.parameters.max_pose_gap_s;
  WATERSKY_TRY(AlignmentRun run, run_alignment(flight, options, progress));
  return std::make_shared<const AlignmentRun>(std::move(run));
}

VerbResult run(const Options& o, const Common& common) {
  WATERSKY_CHECK(validate(o.parameters));
  WATERSKY_CHECK(validate(o.align));
  WATERSKY_CHECK(validate(o.smoothing));
  const int threads = use_threads(o.flight.threads);
  if (!o.projection.empty())
    if (const auto projection = Projection::from_text(o.projection); !projection)
      return Error{ErrorCode::Usage, projection.error().message};
  WATERSKY_TRY(const Segmentation chosen, resolve(o.segmentation));
  // Before any work: a map that cannot be written is an hour lost.
  const WriteOptions write{.overwrite = o.overwrite, .threads = threads};
  WATERSKY_CHECK(check_output(o.out, write));
  std::optional<StoredMap> earlier;
  if (!o.continued.empty()) {
    WATERSKY_TRY(earlier, open_map(disk(), o.continued));
    if (const auto reference = reference_of(earlier->header); !reference)
      return reference.error().at(o.continued);
  }
  const Progress progress = progress_bar(common);
  WATERSKY_TRY(const Flight flight, read_flight_over_sea(o.flight, progress));

  MappingOptions options;
  options.parameters = o.parameters;
  options.method = chosen.method;
  options.ice = chosen.ice;
  options.parameters.segmentation.model = chosen.model;
  options.parameters.segmentation.learned.ponds_are_ice = chosen.ponds_are_ice;
  if (!o.projection.empty()) options.projection = o.projection;
  if (earlier) {
    const MapHeader& header = earlier->header;
    options.projection = header.projection;
    options.parameters.map.cell_m = header.cell_m;
    options.parameters.map.prior = header.prior;
    options.parameters.map.max_probability = header.max_probability;
  }
  options.threads = threads;
  WATERSKY_TRY(const Masks masks, read_masks(o.flight.masks));
  options.camera_mask = masks.camera;
  options.excluded = masks.excluded;

  auto alignment = alignment_of(flight, o, options, progress);
  if (!alignment) return alignment.error().at(o.flight.flight);
  // Where nothing could be aligned the flight is mapped as it was given, by the mapping's own
  // rules, but for what was certainly wrong in its metadata.
  const bool better = *alignment && (*alignment)->alignment.method != AlignMethod::AsGiven;
  auto run = map_flight(better       ? (*alignment)->corrected
                        : *alignment ? (*alignment)->given
                                     : flight,
                        options, progress);
  if (!run) return run.error().at(o.flight.flight);
  if (uses_opencl()) run->notes.emplace_back("The segmentation's filters ran on OpenCL.");
  if (*alignment) run->notes.insert(run->notes.begin(), summary(**alignment));
  run->source_id = source_id_of(flight);
  auto made = earlier ? continued_products_of(*run, *earlier) : Result<Products>(products_of(*run));
  if (!made) return made.error().at(o.continued);
  Products products = *std::move(made);
  products.alignment = *alignment;
  if (o.smooth) WATERSKY_CHECK(add_smoothing(products, *run, o.smoothing));
  WATERSKY_CHECK(write_products(products, o.out, write, progress));

  for (const LeftOut& l : run->left_out) warn(common, "left out: " + l.file + ": " + l.reason);
  for (const UsedFrame& u : run->used) {
    char text[160];
    std::snprintf(text, sizeof text, "%s: %.1f m above the sea, %.3f m a pixel, %.0f %% ice",
                  u.file.c_str(), u.height_above_sea_m, u.gsd_m, 100 * u.ice_fraction);
    say_more(common, text);
  }
  for (const std::string& note : run->notes) say(common, note);
  say(common, "Mapped " + std::to_string(run->used.size()) + " of " +
                  std::to_string(run->frames_total) + " frames of " + run->flight_name + " (" +
                  run->reference.projection.name() + ").");
  say(common, "Report: " + o.out + "/report.html");
  say(common, "Map:    " + o.out + "/probability.tif, " + o.out + "/ice.gpkg");
  if (products.smoothing) {
    char text[160];
    std::snprintf(text, sizeof text,
                  "Smoothed with coupling %.3f (%s): ", products.smoothing->coupling,
                  products.smoothing->best_foretelling ? "chosen from the map" : "given");
    say(common, text + o.out + "/smoothed.tif, " + o.out + "/most_likely.tif");
  }
  return run_json(products);
}

}  // namespace

void add_map(CLI::App& app) {
  auto o = std::make_shared<Options>();
  CLI::App& verb = add_verb(app, "map", "Make a map of the ice from a flight",
                            [o](const Common& common) { return run(*o, common); });
  verb.add_option("-o,--out", o->out, "folder to make with the map and its report")->required();
  add_flight_options(verb, o->flight);
  add_segmentation(verb, o->segmentation);
  verb.add_option("--projection", o->projection,
                  "map projection such as EPSG:3413; chosen from the flight if not given");
  add_mask_option(
      verb, o->flight,
      "what is neither water nor ice: images of the camera's size, 0 where its picture is not to "
      "be used (aircraft, bow), and polygons of the world such as GeoJSON (land, ship)");
  verb.add_flag("--no-align", o->no_align,
                "use times, mount and poses as they are given, without looking for what is wrong "
                "with them in the images");
  add_threads_option(verb, o->flight);
  verb.add_flag(
      "--smooth", o->smooth,
      "write smoothed.tif and most_likely.tif as well, for which a cell's neighbours count "
      "besides its own looks");
  verb.add_flag("--overwrite", o->overwrite, "replace OUT if it is a map of ours");
  add_parameters(verb, o->parameters);
  auto* continued =
      verb.add_option("--continue", o->continued,
                      "an earlier map to go on with: a map file or a folder that holds one; its "
                      "projection, cells and prior are taken, and OUT shows both together");
  for (const char* given : {"--projection", "--cell-m", "--prior", "--max-probability", "--smooth"})
    continued->excludes(verb.get_option(given));
  // Mapping's own gap between poses holds for both.
  add_parameters(verb, o->align, "Parameters of alignment", {"align_max_pose_gap_s"});
  add_parameters(verb, o->smoothing, "Parameters of --smooth");
}

}  // namespace watersky::cli
