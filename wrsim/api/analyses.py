"""Results of runs: assessment, ride, spectra, differences."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from wrsim.api import options
from wrsim.api.options import AnyPath, Argument, Option, documented, into
from wrsim.api.outcome import Outcome, as_list, as_result, as_scenario, folder_or_none, name_of, paths_in
from wrsim.errors import DIFFERENT


@documented
def assess(
    results: Annotated[
        options.ResultsLike,
        Argument("Runs: files, folders, cut off or not. Several count as one test.", "RESULT...", kind=list[Path]),
    ],
    scenario: options.SectionsOf = None,
    output: options.TablesBeside = None,
    pictures: options.Pictures = True,
    rules: Annotated[
        AnyPath,
        Option(
            "Rule set: en14363, uic518, 49cfr213, 49cfr238, a file; default: of the settings.", "NAME|FILE", kind=str
        ),
    ] = None,
) -> Outcome:
    """Assess a run by a rule set: quantities section by section, limits, margins; writes tables and pictures.

    Sections of several runs of one vehicle count together; they need a folder to write to (-o).

    Returns
    -------
    Outcome
        ``value`` is the assessment.

    Raises
    ------
    InputError
        For results that are no runs, or not of one vehicle.
    """
    from wrsim.assessment.assess import assess_runs
    from wrsim.assessment.outcome import assessment_dict, assessment_numbers
    from wrsim.assessment.settings import AssessmentSection
    from wrsim.report.output_folder import naming, unique_names
    from wrsim.report.outputs import write_assessment

    several = as_list(results)
    paths = paths_in(*several)
    names = unique_names(paths) if len(paths) == len(several) else [str(i + 1) for i in range(len(several))]
    settings = None if scenario is None else as_scenario(scenario, ()).table(AssessmentSection).settings()
    loaded = [as_result(each) for each in several]
    with naming(*paths):
        assessment = assess_runs(loaded, settings, names, rules)
    folder = folder_or_none(output)
    files = [] if folder is None else write_assessment(assessment, folder, pictures)
    return Outcome(assessment_numbers(assessment), assessment_dict(assessment), files, assessment, folder=folder)


@documented
def ride(
    result: options.ResultFile,
    scenario: options.SectionsOf = None,
    output: options.TablesBeside = None,
    pictures: options.Pictures = True,
) -> Outcome:
    """Ride: accelerations at the points of a vehicle, their spectra, third-octaves and comfort.

    Returns
    -------
    Outcome
        ``value`` has spectra and bands.

    Raises
    ------
    InputError
        For a result without points, or one too short.
    """
    from wrsim.analysis.ride import evaluate_ride
    from wrsim.report.output_folder import naming
    from wrsim.report.outputs import write_ride
    from wrsim.scenario.sections.run import RideSection

    loaded, section = as_result(result), None if scenario is None else as_scenario(scenario, ()).table(RideSection)
    with naming(*paths_in(result)):
        evaluation = evaluate_ride(loaded, section)
    folder = folder_or_none(output)
    files = [] if folder is None else write_ride(evaluation, folder, pictures)
    return Outcome([evaluation.table()], evaluation.as_dict(), files, evaluation, folder=folder)


@documented
def spectra(
    result: options.ResultFile,
    channel: Annotated[str, Argument("A channel, such as Q or axle_box_acceleration.", "CHANNEL")],
    *,
    derivative: Annotated[int, Option("Order of the derivative; 2 of a displacement.", least=0, most=2)] = 0,
    from_m: Annotated[float | None, Option("Start of the distance that is used.", "M")] = None,
    to_m: Annotated[float | None, Option("End of the distance that is used.", "M")] = None,
    resolution_Hz: Annotated[float, Option("Resolution of the density; coarser in short runs.", "HZ", 1e-3)] = 2.0,
    piece_m: Annotated[float, Option("Length of track of one spectrum of the spectrogram.", "M", 1e-3)] = 2.0,
    output: options.TablesBeside = None,
    pictures: options.Pictures = True,
) -> Outcome:
    """Spectra of a channel of a run: power spectral density, third-octaves, spectrogram over the distance.

    The fast channel is taken where it is stored. Distances are those of the vehicle's origin.

    Returns
    -------
    Outcome
        ``value`` is an xarray.Dataset in SI units: ``density`` (frequency, ...), one-sided; ``band_rms`` (band, ...)
        with ``band_low`` and ``band_high``; ``spectrogram`` (place, line, ...), densities over the distance; ``rms``.

    Raises
    ------
    InputError
        For a channel that the result does not have over time, or one too short.
    """
    from wrsim.analysis.spectra import evaluate_spectra
    from wrsim.report.output_folder import naming
    from wrsim.report.outputs import write_spectra
    from wrsim.results.spectra import spectra_table
    from wrsim.results.table import as_records

    with naming(*paths_in(result)):
        dataset = evaluate_spectra(as_result(result), channel, derivative, (from_m, to_m), resolution_Hz, piece_m)
    folder, table = folder_or_none(output), spectra_table(dataset)
    files = [] if folder is None else write_spectra(dataset, folder, pictures)
    numbers = {"title": dataset.attrs["title"], "channel": channel, "spectra": as_records(table)}
    return Outcome([table], numbers, files, dataset, folder=folder)


@documented
def diff(
    first: options.ResultFile,
    second: options.ResultFile,
    tolerance: Annotated[float, Option("Allowed difference as a part of the quantity's largest value.", "PART")] = 0.01,
    only: Annotated[Sequence[str], Option("Quantity such as Y_over_Q_max; may be repeated.", "QUANTITY")] = (),
    output: Annotated[AnyPath, into("Folder for a table and an overlay picture.", "DIR")] = None,
) -> Outcome:
    """Compare two results: peaks, medians in full curves, other numbers; exit code 4 when they differ.

    Returns
    -------
    Outcome
        ``code`` 4 where they differ; ``value`` lists the deviations.

    Raises
    ------
    InputError
        For results of two kinds, and a quantity that neither has.
    """
    from wrsim.report.output_folder import naming
    from wrsim.report.outputs import write_differences
    from wrsim.results.differences import (
        beyond,
        compared_tables,
        difference_table,
        differences,
        inputs_apart,
        other_ends,
    )
    from wrsim.results.table import as_records

    names = (name_of(first), name_of(second))
    results, paths = (as_result(first), as_result(second)), paths_in(first, second)
    with naming(*paths):
        deviations = differences(*results, only, tolerance)
    ends = other_ends(*results)
    folder = folder_or_none(output)
    files = [] if folder is None else write_differences(deviations, results, names, folder)
    alike = not beyond(deviations, tolerance) and not ends
    records = as_records(difference_table(deviations))
    apart = inputs_apart(*results)
    numbers = {"alike": alike, "tolerance": tolerance, "ends": ends, "inputs": apart, "differences": records}
    tables = compared_tables(deviations, ends, tolerance, names, apart)
    return Outcome(tables, numbers, files, deviations, 0 if alike else DIFFERENT, folder)
