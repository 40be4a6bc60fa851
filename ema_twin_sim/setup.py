"""Installs ema_twin_sim where ROS 2 looks for it, and the command `ema-twin` into the prefix's bin folder."""

from setuptools import find_packages, setup

setup(
    name="ema_twin_sim",
    version="0.1.0",
    description="The digital twin of an electromechanical actuator: physics, effects, comparison, nodes, command line",
    maintainer="EMA twin authors",
    maintainer_email="maintainers@ema-twin.example.org",
    license="Apache-2.0",
    packages=find_packages(),
    package_data={
        "ema_twin_sim": ["py.typed"],
        "ema_twin_sim.report": ["*.css", "*.js"],
        "ema_twin_sim.views": ["*.html", "*.js"],
    },
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/ema_twin_sim"]),
        ("share/ema_twin_sim", ["package.xml"]),
        ("bin", ["scripts/ema-twin"]),
    ],
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "ema-twin = ema_twin_sim.entry:main",
            "monitor = ema_twin_sim.nodes.monitor:main",
            "twin = ema_twin_sim.nodes.twin:main",
        ]
    },
)
