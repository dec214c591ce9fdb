// What is wrong with the layout of the page as it stands: a list of sentences. See looks.py.
([contrast, touch]) => {
  const CONTROL = "button, input, select, textarea, summary, a[href]";
  const root = document.documentElement, { body } = document;
  const screen = { left: 0, top: 0, right: innerWidth, bottom: innerHeight };
  const faults = [];

  const short = (element) => (element.textContent || element.value || element.id).trim().slice(0, 40);
  const say = (what, element, more) => faults.push(`${what}: <${element.localName} id="${element.id}"> '${short(element)}' ${more}`);
  const style = (element) => getComputedStyle(element);
  const seen = (element) => element.checkVisibility({ visibilityProperty: true, opacityProperty: true });

  function parents(element) {
    const all = [];
    for (let one = element.parentElement; one; one = one.parentElement) all.push(one);
    return all;
  }

  function common(a, b) {
    return {
      left: Math.max(a.left, b.left), right: Math.min(a.right, b.right),
      top: Math.max(a.top, b.top), bottom: Math.min(a.bottom, b.bottom),
    };
  }

  const isEmpty = (box, least = 0) => box.right - box.left <= least || box.bottom - box.top <= least;
  const placeOf = (element) => (element === root ? screen : element.getBoundingClientRect());
  const clips = (element) => element !== body && (element === root || style(element).overflowX !== "visible" || style(element).overflowY !== "visible");

  // Whether what does not fit into an element can be scrolled to.
  function scrolls(element, axis) {
    const [whole, part] = axis === "X" ? ["scrollWidth", "clientWidth"] : ["scrollHeight", "clientHeight"];
    if (element[whole] <= element[part]) return false;
    if (element === root) return axis === "Y" && [root, body].every((one) => style(one).overflowY !== "hidden");
    return ["auto", "scroll"].includes(style(element)[`overflow${axis}`]);
  }

  // Why a box in an element cannot be brought onto the screen, empty where it can.
  function outOfReach(element, box) {
    let inner = { left: box.left, right: box.right, top: box.top, bottom: box.bottom };
    for (const outer of parents(element).filter(clips)) {
      const place = placeOf(outer);
      for (const [axis, low, high] of [["X", "left", "right"], ["Y", "top", "bottom"]]) {
        if (scrolls(outer, axis)) {
          inner = { ...inner, [low]: place[low], [high]: place[high] };
        } else if (inner[low] < place[low] - 1 || inner[high] > place[high] + 1) {
          return outer === root && axis === "X" ? "beside the screen" : `cut off by <${outer.localName} id="${outer.id}">`;
        }
      }
    }
    return "";
  }

  const shownPart = (element, box) => parents(element).filter(clips).reduce((left, outer) => common(left, placeOf(outer)), box);

  // ---- what is there: texts, controls, and boxes over something else

  const everything = [...body.querySelectorAll("*")].filter((element) =>
    !["SCRIPT", "STYLE", "OPTION"].includes(element.tagName) && seen(element) && !element.closest(".dg"));
  const texts = [];
  for (const element of everything.filter((one) => !one.closest("select, textarea"))) {
    for (const node of element.childNodes) {
      if (node.nodeType !== Node.TEXT_NODE || !node.data.trim()) continue;
      const range = document.createRange();
      range.selectNodeContents(node);
      for (const box of range.getClientRects()) if (box.width > 0) texts.push({ element, box });
    }
  }
  const controls = everything.filter((element) => element.matches(CONTROL));
  const floating = everything.filter((element) =>
    element.textContent.trim() && style(element).position !== "static" && !/^transparent$|, 0\)$/.test(style(element).backgroundColor));

  // ---- off the screen, or cut off

  if (root.scrollWidth > innerWidth) faults.push(`the page is ${root.scrollWidth} wide, the screen ${innerWidth}`);
  for (const { element, box } of [...texts, ...controls.map((one) => ({ element: one, box: one.getBoundingClientRect() }))]) {
    const why = outOfReach(element, box);
    if (why) say("not in reach", element, why);
  }

  // ---- over each other

  const boxes = [...texts, ...[...controls, ...floating].map((element) => ({ element, box: element.getBoundingClientRect() }))]
    .map(({ element, box }) => ({ element, box: common(shownPart(element, box), screen) }))
    .filter(({ box }) => !isEmpty(box));
  boxes.forEach((a, i) => {
    for (const b of boxes.slice(i + 1)) {
      if (a.element.contains(b.element) || b.element.contains(a.element)) continue;
      if (!isEmpty(common(a.box, b.box), 1.5)) say("lies over another", a.element, `and '${short(b.element)}'`);
    }
  });

  // ---- hard to read; what lies over a picture is held against black and white behind it

  const parsed = (colour) => { const [r, g, b, a = 1] = colour.match(/[\d.]+/g).map(Number); return [r, g, b, a]; };
  const over = ([r, g, b, a], under) => [r, g, b].map((one, i) => one * a + under[i] * (1 - a));

  function luminance(colour) {
    const [r, g, b] = colour.map((one) => (one <= 10.31475 ? one / 255 / 12.92 : ((one / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  }

  function ratio(a, b) {
    const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y);
    return (high + 0.05) / (low + 0.05);
  }

  function worstContrast(element) {
    const picture = element.closest("#scene"), line = [element, ...parents(element)];
    const layers = picture ? line.slice(0, line.indexOf(picture)) : line;
    const bases = picture ? [[0, 0, 0], [255, 255, 255]] : [style(root).colorScheme === "dark" ? [18, 18, 18] : [255, 255, 255]];
    return Math.min(...bases.map((base) => {
      let back = base, shown = 1;
      for (const layer of layers.reverse()) {
        back = over(parsed(style(layer).backgroundColor), back);
        shown *= +style(layer).opacity;
      }
      const [r, g, b, a] = parsed(element.closest("svg") ? style(element).fill : style(element).color);
      return ratio(over([r, g, b, a * shown], back), back);
    }));
  }

  const fields = controls.filter((element) => element.matches("select, textarea, input[type=number], input[type=text]"));
  for (const element of new Set([...texts.map((one) => one.element), ...fields])) {
    if (element.closest(":disabled") || isEmpty(shownPart(element, element.getBoundingClientRect()))) continue;
    const found = worstContrast(element);
    if (!(found >= contrast)) say("hard to read", element, `contrast ${found.toFixed(2)}`);
  }

  // ---- without a name, for who hears the page

  const named = (element) => [
    element.getAttribute("aria-label"), element.title, element.textContent,
    ...[...(element.labels || [])].map((label) => label.textContent),
  ].some((words) => words && /\p{L}|\p{N}/u.test(words));
  for (const element of everything.filter((one) => one.matches(CONTROL) || one.tabIndex >= 0)) {
    if (!scrolls(element, "Y") && !scrolls(element, "X") && !named(element)) say("has no name", element, "");
  }

  // ---- too small for a finger, on a phone

  if (innerWidth <= 760 || innerHeight <= 500) {
    for (const element of controls.filter((one) => !one.matches("a, textarea"))) {
      const target = element.matches("[type=checkbox], [type=radio]") && element.closest("label") || element;
      const { height } = target.getBoundingClientRect();
      if (height < touch - 0.5) say("too small to touch", target, `${height.toFixed(0)} high`);
    }
  }
  return faults;
}
