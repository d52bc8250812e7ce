# three.js as Debian's libjs-three installs it, for the web page; only needed to build.
find_file(DYNEMO_THREE_JS three.min.js PATHS /usr/share/javascript/three REQUIRED)
find_file(DYNEMO_ORBIT_CONTROLS_JS OrbitControls.js PATHS /usr/share/javascript/three/examples/js/controls REQUIRED)
