// What is wider than the page can be scrolled by keyboard; regions of the page have names.
function make_scrollable() {
  for (const wide of document.querySelectorAll("pre, .table-wrapper, .formula")) {
    if (wide.scrollWidth > wide.clientWidth) wide.tabIndex = 0;
    else wide.removeAttribute("tabindex");
  }
}
window.addEventListener("load", make_scrollable);
window.addEventListener("resize", make_scrollable);
window.addEventListener("DOMContentLoaded", () => {
  document.querySelector(".sidebar-drawer")?.setAttribute("aria-label", "Pages");
  document.querySelector(".toc-drawer")?.setAttribute("aria-label", "On this page");
});
