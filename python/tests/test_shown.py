"""What a notebook and a terminal show."""

import arcsmith


def test_reports_are_shown_in_a_frame(folder):
    fit, diagnosis = arcsmith.fit("warm.csv", "mirror.toml"), arcsmith.diagnose("warm.csv", "mirror.toml")
    for result in (fit, diagnosis):
        assert result.report().startswith("<!doctype html>")
        assert result._repr_html_().startswith('<iframe srcdoc="&lt;!doctype html&gt;')
    assert "rms" in repr(fit) and "explained by thermal_zero_drift" in repr(diagnosis)
    assert "coefficients" in str(fit) and "\x1b" not in str(fit) + str(diagnosis)


def test_figures(folder, tmp_path):
    for result in (arcsmith.fit("warm.csv", "mirror.toml"), arcsmith.diagnose("warm.csv", "mirror.toml")):
        figures = result.plot()
        assert len(figures) >= 3 and all(svg.startswith("<svg") and "--ink" in svg for svg in figures.values())
        assert len(set(figures.save(tmp_path))) == len(figures)
        assert figures._repr_html_().count("&lt;svg") == len(figures)


def test_columns_and_routines(folder):
    fit = arcsmith.fit("calibration.csv", "mirror.toml")
    applied = arcsmith.apply("warm.csv", fit)
    assert "angle_arcsec" in applied._repr_html_() and list(applied.plot()) == ["angle_arcsec", "extrapolated"]
    assert "corrected_angle_q31" in arcsmith.generate(fit, format="q31")._repr_html_()


def test_everything_public_has_its_documentation():
    for name in arcsmith.__all__:
        if not name.startswith("__"):
            assert getattr(arcsmith, name).__doc__, name
