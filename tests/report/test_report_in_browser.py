"""The report as a browser shows it: every chart drawn, nothing complained of, nothing loaded, readable on a phone."""

import pytest

from ema_twin_sim.report.page import page
from tests.browser import CHROMIUM, Browser
from tests.report.test_report import LARGEST, content_of, findings, folder, models, recordings, written  # noqa: F401
from tests.report.test_report_of_three_models import content, three, told  # noqa: F401

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="chromium is missing: sudo apt install chromium")

DRAWN = "[...document.querySelectorAll('.chart')].filter(c => c.querySelectorAll('.trace').length).length"
PLACES = "document.querySelectorAll('.chart').length"
TOO_WIDE = """[...document.querySelectorAll('main *')].filter(e => !e.closest('.scroll, .stacked, nav, svg')
    && e.getBoundingClientRect().right > innerWidth + 1).map(e => e.tagName + '.' + e.className)"""
TOO_SMALL = """[...document.querySelectorAll('main p, main td, main li, figcaption, .chart text')].filter(
    e => e.textContent && parseFloat(getComputedStyle(e).fontSize) < 11).length"""


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    browser = Browser(tmp_path_factory.mktemp("browser"))
    yield browser
    browser.close()


@pytest.fixture(scope="module")
def report(tmp_path_factory, written):  # noqa: F811
    path = tmp_path_factory.mktemp("page") / "report.html"
    path.write_text(written)
    assert path.stat().st_size < LARGEST
    return path


@pytest.mark.slow
@pytest.mark.parametrize(("width", "scheme"), [(1280, "light"), (400, "dark")])
def test_every_chart_is_drawn_and_everything_fits(browser, report, tmp_path, width, scheme):
    for heard in (browser.errors, browser.warnings, browser.requested):
        heard.clear()
    browser.look(report, width, scheme=scheme)
    assert browser.ask(DRAWN) == browser.ask(PLACES) >= 12
    assert browser.ask("document.documentElement.scrollWidth") <= width
    assert browser.ask(TOO_WIDE) == [] and browser.ask(TOO_SMALL) == 0
    assert browser.errors == browser.warnings == [] and browser.requested == [report.as_uri()]
    browser.picture(tmp_path / "page.png")
    assert (tmp_path / "page.png").stat().st_size > 100_000


@pytest.mark.slow
def test_text_stands_out_of_its_ground(browser, report):
    """The contrast of text and of plots' text, which accessibility guidelines want to be 4.5 or more."""
    contrast = """(() => {
        const light = (text) => { const [r, g, b] = text.match(/[\\d.]+/g).map(v => v / 255)
            .map(v => v <= 0.04 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
            return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
        const ground = light(getComputedStyle(document.body).backgroundColor);
        return ['main h1', '.aside', 'nav a', '.good, .plain', '.chart text'].map(name => {
            const each = document.querySelector(name), style = getComputedStyle(each);
            const own = light(each.namespaceURI.endsWith('svg') ? style.fill : style.color);
            return (Math.max(own, ground) + 0.05) / (Math.min(own, ground) + 0.05); });
    })()"""
    for scheme in ("light", "dark"):
        browser.look(report, scheme=scheme)
        assert min(browser.ask(contrast)) >= 4.5


def test_links_lead_to_their_sections(browser, report):
    browser.look(report)
    links = browser.ask("[...document.querySelectorAll('a')].map(a => a.getAttribute('href'))")
    assert len(links) >= 7
    for link in links:
        browser.ask(f"document.querySelector('a[href=\"{link}\"]').click()")
        assert browser.ask("location.hash") == link
        assert browser.ask(f"document.querySelector('{link}').getBoundingClientRect().height") > 0


def test_the_choice_of_recording_redraws_and_zoom_is_linked_in_time(browser, report):
    browser.look(report)
    end = "[...document.querySelectorAll('.chart')].slice(0, 3).map(c => c._fullLayout.xaxis.range[1])"
    first = "document.querySelector('.chart').calcdata[0][300].y"
    before = browser.ask(first)
    browser.ask("{ const s = document.getElementById('recording'); s.selectedIndex = (s.selectedIndex + 1) % 3;"
                " s.dispatchEvent(new Event('change')) }")  # fmt: skip
    browser.wait(f"{first} !== {before}")
    browser.ask("void Plotly.relayout(document.querySelector('.chart'), {'xaxis.range[0]': 1, 'xaxis.range[1]': 2})")
    browser.wait(f"{end}.every(value => value === 2)")
    browser.ask("void Plotly.relayout(document.querySelector('.chart'), {'xaxis.autorange': true})")
    browser.wait(f"{end}.every(value => value > 4)")


def test_a_name_in_the_key_hides_its_curves(browser, report):
    browser.look(report)
    shown = "document.querySelector('.chart').data.filter(trace => trace.visible).length"
    assert browser.ask(shown) == 5
    browser.ask("document.querySelector('button[data-role=before]').click()")
    browser.wait(f"{shown} === 3")


@pytest.mark.slow
def test_it_prints_on_light_ground(browser, report, tmp_path):
    browser.look(report, scheme="dark")
    colour = "document.querySelector('.chart text').style.fill"
    browser.ask("addEventListener('beforeprint', () => { window.printed = true })")
    dark = browser.ask(colour)
    browser.ask("dispatchEvent(new Event('beforeprint'))")
    browser.wait(f"{colour} !== '{dark}' && document.querySelector('.main-svg').clientWidth <= 660")
    browser.ask("dispatchEvent(new Event('afterprint'))")
    browser.wait(f"{colour} === '{dark}' && document.querySelector('.main-svg').clientWidth > 660")
    browser.print(tmp_path / "report.pdf")
    assert browser.ask("window.printed") and (tmp_path / "report.pdf").read_bytes().count(b"/Type /Page\n") >= 4


@pytest.mark.slow
def test_three_models_are_in_every_chart_and_in_the_key(browser, tmp_path, content):  # noqa: F811
    (tmp_path / "three.html").write_text(page(content))
    browser.errors.clear()
    browser.look(tmp_path / "three.html")
    assert browser.ask(DRAWN) == browser.ask(PLACES) and browser.errors == [] and browser.ask(TOO_WIDE) == []
    colours = "[...document.querySelectorAll('.controls .swatch')].map(s => getComputedStyle(s).backgroundColor)"
    assert len(set(browser.ask(colours))) == 5  # measured, three models, the noise
    shown = "document.querySelector('.chart').data.filter(trace => trace.visible).length"
    assert browser.ask(shown) == 7
    browser.ask("document.querySelector('button[data-role=fitted]').click()")
    browser.wait(f"{shown} === 5")
