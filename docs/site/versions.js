// Lists the other versions of the site in the sidebar. `scripts/docs --publish FOLDER` writes their names into FOLDER/versions.js, beside
// the folder of this version; without that file nothing is shown.
(() => {
  const root = (document.documentElement.dataset.content_root || "./") + "../";
  const names = document.createElement("script");
  names.src = root + "versions.js";
  names.onload = () => {
    const list = document.createElement("ul");
    for (const name of window.turgorVersions) {
      const item = list.appendChild(document.createElement("li"));
      item.className = "toctree-l1";
      const link = item.appendChild(document.createElement("a"));
      link.className = "reference internal";
      link.href = root + name + "/index.html";
      link.textContent = name;
    }
    const box = document.createElement("div");
    box.className = "sidebar-tree";
    box.innerHTML = '<p class="caption" role="heading"><span class="caption-text">Versions</span></p>';
    box.append(list);
    document.querySelector(".sidebar-scroll")?.prepend(box);
  };
  document.head.append(names);
})();
