#include "bench/verbs/sweep_options.h"

namespace dapple::bench {

void SweepOptions::addTo(CLI::App& verb) {
    verb.add_option("SWEEP", sweep, "a sweep's file (.toml), or its name as `dapple list sweeps` gives it")->required();
    verb.add_option("-a,--axis", overrides, "axis=value,value instead of the sweep's values; may be repeated")->allow_extra_args(false);
    verb.add_option("--filter", filters,
                    "only points in whose 'scene technique axis=value … view' this regular expression (RE2) is found; "
                    "may be repeated")
        ->allow_extra_args(false);
}

Sweep SweepOptions::read() const {
    Sweep result = readSweep(sweep);
    for (const std::string& assignment : overrides) overrideAxis(result, assignment);
    return result;
}

}  // namespace dapple::bench
