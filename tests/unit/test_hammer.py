"""The hammer test: what is chosen, refused, said and written."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import flexmech
from flexmech import HammerRequest, InputError, LinkPoint
from flexmech.analyses.hammer.locked_linkage import LockedLinkage
from flexmech.analyses.hammer.plan import RecordPlan, planned_record
from flexmech.analyses.hammer.transient import taken_record
from flexmech.cli import app
from tests.support.hammer_data import ALUMINIUM, damped_engine, small_request, small_test

pytestmark = pytest.mark.usefixtures("rough_pictures")

ANGLE = np.radians([96.9])
RESPONSE = LinkPoint("rocker", 0.4)


def plan_of(**asked: Any) -> tuple[RecordPlan, LockedLinkage]:
    request = HammerRequest(ANGLE, **({"modes": 2} | asked))
    locked = LockedLinkage.at(damped_engine(), float(ANGLE[0]), "none")
    return planned_record(request, [locked]), locked


class TestPlan:
    def test_what_is_left_open_is_chosen_as_a_laboratory_does(self):
        plan, locked = plan_of()
        highest = locked.natural_frequencies(2)[-1]
        assert 1.25 * highest <= plan.bandwidth < 1.4 * highest
        assert plan.sampling_rate == pytest.approx(2.56 * plan.bandwidth)
        assert plan.pulse.duration == pytest.approx(1 / plan.bandwidth)
        lines = plan.samples / 2.56
        assert lines / 200 == 2 ** round(np.log2(lines / 200))
        assert plan.window is None

    def test_a_record_lasts_until_the_vibration_has_decayed(self):
        plan, locked = plan_of()
        record = taken_record(
            locked, plan, LinkPoint("coupler", 0.5), LinkPoint("coupler", 0.5), "transverse"
        )
        end = np.abs(record.response[-plan.samples // 50 :]).max()
        assert end < 1.1e-4 * np.abs(record.response).max()

    def test_the_recorded_force_is_the_pulse_in_the_band(self):
        """Its spectrum, with the delay of its middle: the filter adds none."""
        plan, locked = plan_of()
        point = LinkPoint("coupler", 0.5)
        record = taken_record(locked, plan, point, point, "transverse")
        lines = np.arange(int(plan.bandwidth * plan.duration)) / plan.duration
        found = np.fft.rfft(record.force)[: len(lines)] / plan.sampling_rate
        exact = plan.pulse.spectrum(lines)
        assert np.abs(found - exact).max() < 1e-3 * plan.pulse.momentum

    def test_links_move_a_millionth_of_the_shortest_one(self):
        plan, locked = plan_of()
        hit = locked.rows([LinkPoint("coupler", 0.5)], "transverse")[0]
        time = plan.pulse.start + np.linspace(0, 0.2, 500)
        moved = np.abs(locked.motion(locked.station_rows(), hit, plan.pulse, time)).max()
        shortest = min(link.length for link in locked.system.frames.topology.links)
        assert 0.35e-6 * shortest < moved < 1.05e-6 * shortest
        digits = plan.pulse.peak_force / 10.0 ** np.floor(np.log10(plan.pulse.peak_force))
        assert round(digits, 9) in (1, 2, 5)

    def test_a_short_record_gets_an_exponential_window(self):
        whole, locked = plan_of()
        half, _ = plan_of(duration=whole.duration / 4)
        assert half.samples == pytest.approx(whole.samples / 4, abs=2)
        assert half.window is not None
        slowest = -locked.poles(half.bandwidth).real.max()
        left = half.duration - half.pulse.end
        assert np.exp(-(slowest + half.decay_rate) * left) == pytest.approx(1e-4)

    def test_a_long_pulse_lowers_the_bandwidth(self):
        assert plan_of(pulse=0.02)[0].bandwidth == pytest.approx(50.0)

    def test_a_short_pulse_is_resolved(self):
        plan, _ = plan_of(pulse=1e-4)
        assert plan.pulse.duration >= 20 * plan.step


class TestRefusals:
    @pytest.mark.parametrize(
        ("asked", "words"),
        [
            ({"pulse": 0.5, "duration": 0.2}, "longer than the record.*shorter pulse or a longer"),
            ({"pulse": 0.01, "duration": 0.0101}, "longer than the record|more$"),
            ({"bandwidth": 1e6}, "above .* Hz, up to which 2 elements.*more elements"),
            ({"bandwidth": 60.0, "pulse": 0.05}, "excites frequencies up to 26 Hz.*give a pulse"),
            ({"bandwidth": 60.0, "duration": 0.1}, r"has \d+ samples.*or more"),
            ({"duration": 1e6}, "steps, more than .* shorter duration"),
            ({"bandwidth": 20.0}, "below 20 Hz.*first at 44.89 Hz; give a greater bandwidth"),
            ({"pulse": 0.1}, "below 10 Hz.*or a shorter pulse"),
            ({"averages": 0}, "averages must be 1 or more"),
            ({"noise": -0.1}, "noise must be zero or positive"),
            ({"duration": -1.0}, "duration must be positive"),
            ({"direction": "upward"}, "direction must be one of"),
            ({"grid": 1}, "grid must be 2 or more"),
            ({"impact": LinkPoint("crank", 0.0)}, "held by a joint.*such as crank:0.5"),
            ({"impact": LinkPoint("couple", 0.5)}, "did you mean 'coupler'"),
        ],
    )
    def test_one_message_with_the_remedy(self, asked: dict[str, Any], words: str):
        with pytest.raises(InputError, match=words):
            flexmech.hammer_test(damped_engine(), HammerRequest(ANGLE, **({"modes": 2} | asked)))

    def test_an_undamped_linkage_never_decays(self):
        engine = flexmech.ReferenceEngine(flexmech.load_mechanism(ALUMINIUM), 2)
        with pytest.raises(InputError, match=r"not damped.*never decays.*--damping-ratio"):
            flexmech.hammer_test(engine, HammerRequest(ANGLE, modes=2))

    @pytest.mark.parametrize("angles", [[1.0, 0.5], [], [10.0, 200.0, 300.0]])
    def test_angles_increase_and_are_no_degrees(self, angles: list[float]):
        with pytest.raises(InputError, match="crank_angles"):
            HammerRequest(angles)


class TestResult:
    def test_modes_of_every_angle_are_found(self):
        modes = small_test().identified()
        assert modes["crank_angle_deg"].unique().tolist() == pytest.approx([30.0, 96.9])
        first = modes[modes["mode"] <= 2]
        np.testing.assert_allclose(first["frequency_Hz"], first["eigen_frequency_Hz"], rtol=1e-3)
        assert modes["mac"].isna().all()

    def test_noise_is_that_of_the_seed(self):
        clean, noisy = small_test().dataset, small_test(0.01).dataset
        for name in ("force", "response"):
            added = noisy[name] - clean[name]
            ratio = added.std("time") / np.sqrt((clean[name] ** 2).mean("time"))
            np.testing.assert_allclose(ratio, 0.01, rtol=0.1)
        assert float(clean["coherence"].min()) > 1 - 1e-9
        assert float(noisy["coherence"].min()) < 0.999
        same = flexmech.hammer_test(damped_engine(), small_request(0.01)).dataset
        np.testing.assert_array_equal(same["force"], noisy["force"])

    def test_a_window_is_taken_off_the_damping(self):
        found = flexmech.hammer_test(
            damped_engine(),
            HammerRequest(ANGLE, modes=2, duration=0.9, response=RESPONSE, method="circle-fit"),
        )
        assert found.dataset.attrs["window_decay_rate"] > 4
        assert float(found.dataset["simulation_error"].max()) < 0.01
        modes = found.identified().head(2)
        np.testing.assert_allclose(modes["damping_ratio"], modes["eigen_damping_ratio"], rtol=0.05)
        assert "exponential" in str(found.summary())

    def test_a_short_record_is_identified_by_models_of_few_modes(self):
        """LSCF, of 55 lines."""
        pytest.importorskip("sdypy.EMA")
        request = HammerRequest(ANGLE, modes=2, duration=0.9, response=RESPONSE, method="lscf")
        modes = flexmech.hammer_test(damped_engine(), request).identified().head(2)
        np.testing.assert_allclose(modes["frequency_Hz"], modes["eigen_frequency_Hz"], rtol=1e-3)
        np.testing.assert_allclose(modes["damping_ratio"], modes["eigen_damping_ratio"], rtol=0.05)

    def test_files_come_back_equal(self, tmp_path: Path):
        found = small_test(0.01)
        found.save(tmp_path)
        assert found.dataset.identical(flexmech.HammerTest.load(tmp_path / "hammer.nc").dataset)
        frf = pd.read_csv(tmp_path / "frf.csv")
        assert list(frf) == [
            "crank_angle_deg",
            "frequency_Hz",
            "receptance_real_m_N",
            "receptance_imag_m_N",
            "coherence",
        ]
        assert list(pd.read_csv(tmp_path / "identified.csv")) == [
            "crank_angle_deg",
            "mode",
            "frequency_Hz",
            "damping_ratio",
            "eigen_frequency_Hz",
            "eigen_damping_ratio",
            "mac",
        ]

    def test_words_are_those_of_the_paper(self):
        said = small_test().summary()
        assert said.tables[0].headings[2:4] == ("FE Hz", "Ex Hz")
        assert len(said.tables[0].groups) == 2
        assert "identified against eigen model, first" in said.trust

    def test_a_mode_that_is_not_seen_is_named(self):
        dataset = small_test().dataset.copy(deep=True)
        dataset["identified_frequency"][1, 1] = np.nan
        (warning,) = flexmech.HammerTest(dataset).summary().warnings
        assert warning.startswith("crank angle 96.9 deg: mode 2 not identified: nearly a node")


def run(*arguments: Any) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, [str(each) for each in arguments])
    return result.exit_code, result.stdout, result.stderr


class TestCommand:
    ASKED = ("hammer", ALUMINIUM, "--engine", "reference", "--elements", 2)

    def test_files_and_words(self, tmp_path: Path):
        code, printed, errors = run(
            *self.ASKED,
            *("--angle", "30,96.9", "--damping-ratio", "2%", "--impact", "coupler:0.4"),
            *("--response", "rocker:0.5", "--bandwidth", "60 Hz", "--noise", "1%", "--seed", 3),
            *("--out", tmp_path),
        )
        assert code == 0, errors
        assert "impact at coupler:0.4" in " ".join(printed.split())
        names = {path.name for path in tmp_path.iterdir()}
        assert {"frf.csv", "identified.csv", "hammer.nc", "hammer.png", "frf.png"} <= names
        assert {"frf_parts.png", "nyquist.png"} <= names
        assert pd.read_csv(tmp_path / "frf.csv")["frequency_Hz"].max() == pytest.approx(60.0)

    @pytest.mark.parametrize(
        ("options", "words"),
        [
            ((), "--damping-ratio"),
            (("--impact", "coupler"), "--impact: got 'coupler', which is no point of a link"),
            (("--response", "arm:0.5"), "--response: the point arm:0.5 is on no link"),
            (("--impact", "coupler:1.5"), "--impact: the point coupler:1.5 is off its link"),
            (("--bandwidth", "0"), "--bandwidth: must be positive"),
            (("--duration", "-1"), "--duration: must be positive"),
            (("--noise", "loud"), "--noise"),
            (("--angle", "90,30"), "--angle"),
        ],
    )
    def test_bad_options_are_one_message(
        self, options: tuple[str, ...], words: str, tmp_path: Path
    ):
        code, _, errors = run(*self.ASKED, *options, "--no-plots", "--out", tmp_path)
        assert code == 2
        assert words in errors
        assert len(errors.strip().splitlines()) == 1
        assert not list(tmp_path.iterdir())
